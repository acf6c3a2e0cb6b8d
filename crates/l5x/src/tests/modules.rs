//! Modules, and tags that controllers share: the parts that exist without hardware.

use crate::logic;

fn file(modules: &str, tags: &str) -> String {
    format!(
        "<RSLogix5000Content SchemaRevision=\"1.0\" TargetName=\"Cell\" TargetType=\"Controller\"><Controller Use=\"Target\" Name=\"Cell\">\
         <Modules>{modules}</Modules><Tags>{tags}</Tags></Controller></RSLogix5000Content>"
    )
}

/// A module with an upstream port, and the content of its connections.
fn module(name: &str, parent: &str, port: &str, connection: &str) -> String {
    format!(
        "<Module Name=\"{name}\" ParentModule=\"{parent}\"><Ports><Port Id=\"1\" {port} Upstream=\"true\"/></Ports><Communications>\
         <Connections>{connection}</Connections></Communications></Module>"
    )
}

const DATA: &str = r#"<Data Format="Decorated"><Structure DataType="AB:DI:I:0"><ArrayMember Name="Data" DataType="SINT" Dimensions="2">
<Element Index="[0]" Value="0"/><Element Index="[1]" Value="0"/></ArrayMember></Structure></Data>"#;

#[test]
fn modules_have_tags_or_a_reason_why_not() {
    let in_slot = |slot: u32| format!("Address=\"{slot}\" Type=\"ICP\"");
    let ethernet = "Address=\"10.0.0.2\" Type=\"Ethernet\"";
    let connection = |inside: &str| format!("<Connection Name=\"C\">{inside}</Connection>");
    let raw = "<InputTag><Data Format=\"L5K\">[0,0]</Data></InputTag>";
    let rack = "<RackConnection Name=\"R\"><InAliasTag/><OutAliasTag/></RackConnection>";
    let modules = [
        module("Local", "Local", &in_slot(0), ""),
        module(
            "Inputs",
            "Local",
            &in_slot(1),
            &connection(&format!("<InputTag>{DATA}</InputTag>")),
        ),
        module("Raw", "Local", &in_slot(2), &connection(raw)),
        module("Empty", "Local", &in_slot(3), &connection("<OutputTag/>")),
        module(
            "Adapter",
            "Local",
            ethernet,
            &connection(&format!("<InputTag>{DATA}</InputTag>")),
        ),
        module("Racked", "Adapter", &in_slot(1), rack),
        module("Drive", "Local", ethernet, "<Connection Name=\"MotionSync\"/>"),
    ];
    let project = logic(&file(&modules.concat(), ""), "cell.L5X").expect("it is read");
    let tags: Vec<_> = project
        .tags
        .iter()
        .map(|tag| (tag.name.as_str(), tag.alias.as_deref()))
        .collect();
    assert_eq!(
        tags,
        [
            ("Local:1:I", None),
            ("Adapter:I", None),
            ("Adapter:1:I", Some("Adapter:I.Data[1]")),
        ]
    );
    let members = "which name its members: there is no such tag";
    let expected = [
        ("Local:2:I", format!("has no data of the format Decorated, {members}")),
        ("Local:3:O", format!("has no data, {members}")),
        (
            "Adapter:1:O",
            "its data is that of Adapter:O, which is not there: there is no such tag".to_owned(),
        ),
    ];
    assert_eq!(
        project.outside,
        expected.map(|(name, reason)| (name.to_owned(), reason))
    );
    assert_eq!(project.modules.len(), 7);
}

#[test]
fn tags_that_controllers_share_are_plain_tags_and_named() {
    let tags = r#"<Tag Name="Out" TagType="Produced" DataType="DINT"><ProduceInfo ProduceCount="2"/></Tag>
        <Tag Name="In" TagType="Consumed" DataType="DINT"><ConsumeInfo Producer="Line" RemoteTag="Out" RPI="20"/></Tag>
        <Tag Name="Own" TagType="Base" DataType="DINT"/>"#;
    let project = logic(&file("", tags), "cell.L5X").expect("it is read");
    assert_eq!(project.tags.len(), 3);
    let expected = [
        "tag Out: is produced, but nobody receives it: it is a plain tag",
        "tag In: is consumed from Line, but nothing comes: it is a plain tag",
    ];
    let found: Vec<String> = project.findings.iter().map(ToString::to_string).collect();
    assert_eq!(found, expected);
}

#[test]
fn pending_edits_of_structured_text_are_named_and_do_not_run() {
    let text = |edit: &str, line: &str| {
        format!("<STContent OnlineEditType=\"{edit}\"><Line Number=\"0\"><![CDATA[{line}]]></Line></STContent>")
    };
    let routines = format!(
        "<Programs><Program Name=\"Main\"><Routines><Routine Name=\"R\" Type=\"ST\">{}{}</Routine><Routine Name=\"S\" Type=\"ST\">{}</Routine>\
         </Routines></Program></Programs></Controller>",
        text("Pending", "a := 2;"),
        text("Original", "a := 1;"),
        text("Original", "a := 3;")
    );
    let text = file("", "").replacen("</Controller>", &routines, 1);
    let project = logic(&text, "cell.L5X").expect("it is read");
    let found: Vec<String> = project.findings.iter().map(ToString::to_string).collect();
    assert_eq!(found, ["Main/R: text: has pending edits; the text in force runs"]);
    let arcline_routine::source::Content::Text(lines) = &project.programs[0].routines[0].content else {
        panic!("it is Structured Text");
    };
    assert_eq!(*lines, [(0, "a := 1;".to_owned())]);
}
