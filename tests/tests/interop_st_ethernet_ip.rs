//! An unmodified st-ethernet-ip: every type and shape of tag, moves, refusals. The script says what is expected.

#[test]
fn st_ethernet_ip_works_unmodified() {
    arcline_tests::interop::node("st_ethernet_ip.js");
}
