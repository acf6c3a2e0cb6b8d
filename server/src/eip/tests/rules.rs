//! Tags with rules for their writers: a least role, and a range (spec/security.md §6).

use arcline_config::Role;
use arcline_proto::logix::ReadModifyWrite;
use arcline_tag::Elementary;

use super::*;

const RULES: &str = r#"
[[tag]]
name = "Feed"
type = "REAL"
min = 0.0
max = 250.0
[[tag]]
name = "Counts"
type = "DINT[4]"
min = -10
max = 1000
value = [1, 2, 3, 4]
[[tag]]
name = "First"
alias = "Counts[0]"
[[tag]]
name = "Recipe"
type = "DINT"
write_role = "engineer"
[[tag]]
name = "Serial"
type = "DINT[2]"
write_role = "administrator"
"#;

fn bench() -> Bench {
    let text = format!("{}{RULES}", arcline_config::DEFAULT);
    let project = arcline_config::load(&text, "rules").unwrap_or_else(|error| panic!("{error}"));
    Bench::of(Plant::start(&project).expect("a thread"), settings_of("Bench"))
}

#[tokio::test]
async fn a_number_outside_of_the_range_of_a_tag_is_refused_and_nothing_is_written() {
    let (real, dint) = (Elementary::Real.into(), Elementary::Dint.into());
    let counts = |numbers: &[i32]| {
        numbers
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect::<Vec<u8>>()
    };
    let modify = |bit: u8| {
        let masks = ReadModifyWrite::bit(4, bit, true);
        Request::new(service::READ_MODIFY_WRITE_TAG, path("Counts[3]"), masks.to_bytes())
    };
    #[rustfmt::skip]
    let cases = [
        ("inside",                    write("Feed", real, 1, &250_f32.to_le_bytes()),          0),
        ("above",                     write("Feed", real, 1, &250.1_f32.to_le_bytes()),        9),
        ("no number",                 write("Feed", real, 1, &f32::NAN.to_le_bytes()),         9),
        ("all elements",              write("Counts", dint, 4, &counts(&[5, 6, 7, 8])),        0),
        ("one of them outside",       write("Counts", dint, 4, &counts(&[9, 9, 1001, 9])),     9),
        ("by an alias",               write("First", dint, 1, &counts(&[-11])),                9),
        ("an element",                write("Counts[2]", dint, 1, &counts(&[-10])),            0),
        ("masks that make it large",  modify(20),                                              9),
        ("masks that do not",         modify(0),                                             0),
    ];
    let bench = bench();
    let mut client = bench.client().await;
    for (why, request, status) in cases {
        assert_eq!(codes(client.ask(&request).await.status), (status, 0), "{why}");
    }
    assert_eq!(client.read("Feed").await.data, 250_f32.to_le_bytes()[..]);
    let kept = client.ask(&read("Counts", 4)).await;
    assert_eq!(
        ReadReply::decode(&kept.data).expect("DINTs").data,
        counts(&[5, 6, -10, 9])
    );
}

#[tokio::test]
async fn a_tag_may_need_a_higher_role() {
    let bench = bench();
    for role in Role::ALL {
        let mut client = bench.client_as(role).await;
        for (tag, least) in [
            ("Counts[1]", Role::Operator),
            ("Recipe", Role::Engineer),
            ("Serial[1]", Role::Administrator),
        ] {
            let status = codes(
                client
                    .ask(&write(tag, Elementary::Dint.into(), 1, &[0; 4]))
                    .await
                    .status,
            );
            let expected = if role < least { (0x0F, 0) } else { (0, 0) };
            assert_eq!(status, expected, "{tag} as {}", role.word());
        }
    }
}
