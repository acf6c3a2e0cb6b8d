//! Files as Studio writes them: values that are imported, reported and refused.

use crate::{Import, Problem, Reason, export, import, mapping};

/// A project with `inside` in its controller.
fn l5x(inside: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>\r\n\
         <RSLogix5000Content SchemaRevision=\"1.0\" TargetName=\"Cell\" TargetType=\"Controller\">\r\n\
         <Controller Use=\"Target\" Name=\"Cell\">{inside}</Controller></RSLogix5000Content>"
    )
}

fn read(inside: &str) -> Import {
    import(&l5x(inside), "cell.L5X").expect("a file that can be read")
}

fn reported(import: &Import) -> Vec<String> {
    let groups = import.report.groups();
    groups
        .map(|(reason, path, group)| format!("{} × {path}: {reason}", group.count))
        .collect()
}

#[test]
fn axes_systems_and_the_group() {
    let import = read(
        r#"<Tags>
        <Tag Name="Group1" TagType="Base" DataType="MOTION_GROUP" ExternalAccess="Read/Write"><Data Format="MotionGroup">
            <MotionGroupParameters CoarseUpdatePeriod="2000" PhaseShift="0" AutoTagUpdate="Enabled"/></Data></Tag>
        <Tag Name="Lift" TagType="Base" DataType="AXIS_CIP_DRIVE" ExternalAccess="Read/Write"><Data Format="Axis">
            <AxisParameters MotionGroup="Group1" MotionModule="Drive:Ch1" AxisConfiguration="Position Loop" ConversionConstant="1000.0"
                PositionUnits="mm" PositionUnwind="360000" HomeMode="Active" HomeDirection="Uni-directional Reverse"
                HomeSequence="Torque Level-Marker" HomePosition="0.0" HomeSpeed="5.0" HomeReturnSpeed="1.0" MaximumSpeed="500.0"
                MaximumAcceleration="5000.0" MaximumDeceleration="4000.0" ProgrammedStopMode="Hard Disable" TravelMode="Limited"
                VelocityFeedforwardGain="95.0" PositionLoopBandwidth="12.5" PositionErrorTolerance="0.5" SoftTravelLimitChecking="true"
                SoftTravelLimitPositive="800.0" SoftTravelLimitNegative="-10.0" MaximumAccelerationJerk="1E+5"
                MaximumDecelerationJerk="90000.0" AverageVelocityTimebase="0.1" NewInVersion99="1"
                MotionExceptionAction="Unsupported StopPlanner Disable Unsupported"/></Data></Tag>
        <Tag Name="Table" TagType="Base" DataType="AXIS_VIRTUAL" ExternalAccess="Read/Write"><Data Format="Axis">
            <AxisParameters MotionGroup="Group1" ConversionConstant="8000.0" RotaryAxis="Rotary" PositionUnwind="2880000"
                MaximumSpeed="0.0" MaximumAcceleration="0.0" MaximumDeceleration="0.0" DynamicsConfigurationBits="16#0000_0003"/></Data></Tag>
        <Tag Name="CS" TagType="Base" DataType="COORDINATE_SYSTEM" ExternalAccess="Read/Write"><Data Format="CoordinateSystem">
            <CoordinateSystemParameters MotionGroup="Group1" SystemType="Cartesian" Dimension="2" Axes="Lift Table"
                CoordinationMode="Primary Primary" ConversionRatioNumerator="1.0 1.0" MaximumPendingMoves="1" MaximumSpeed="9.0"
                MaximumAcceleration="8.0" MaximumDeceleration="7.0" MaximumAccelerationJerk="6.0" MaximumDecelerationJerk="5.0"
                ActualPositionTolerance="0.25" CommandPositionTolerance="0.5" LinkLength1="0.0" DynamicsConfigurationBits="13"/></Data></Tag>
        <Tag Name="Delta" TagType="Base" DataType="COORDINATE_SYSTEM" ExternalAccess="Read/Write"><Data Format="CoordinateSystem">
            <CoordinateSystemParameters SystemType="Delta" Dimension="3" Axes="{none} {none} {none}"/></Data></Tag>
        </Tags>"#,
    );
    let text = arcline_config::format(&import.config);
    let expected = r#"[server]
name = "Cell"

[motion_group]
name = "Group1"
coarse_update_period_ms = 2.0

[[axis]]
name = "Lift"
type = "servo"
units = "mm"
max_speed = 500.0
max_acceleration = 5000.0
max_deceleration = 4000.0
max_acceleration_jerk = 100000.0
max_deceleration_jerk = 90000.0
travel = { max = 800.0, min = -10.0 }
drive = { position_bandwidth_hz = 12.5, position_error_tolerance = 0.5, velocity_feedforward = 0.95 }
home = { direction = "unidirectional-reverse", mode = "active", position = 0.0, return_speed = 1.0, sequence = "torque-marker", speed = 5.0 }
programmed_stop_mode = "hard_disable"
exception_actions = { soft_travel_negative = "stop_drive", soft_travel_positive = "stop_planner" }
average_velocity_timebase = 0.1

[[axis]]
name = "Table"
type = "virtual"
max_speed = 100.0
max_acceleration = 1000.0
max_deceleration = 0.0
dynamics_configuration_bits = 3
unwind = 360.0
home = {}
exception_actions = {}

[[coordinate_system]]
name = "CS"
axes = ["Lift", "Table"]
max_speed = 9.0
max_acceleration = 8.0
max_deceleration = 7.0
max_acceleration_jerk = 6.0
max_deceleration_jerk = 5.0
dynamics_configuration_bits = 5
actual_tolerance = 0.25
command_tolerance = 0.5
queue_depth = 1
"#;
    assert_eq!(text, expected);
    let parameters = "Controller/Tags/Tag[AXIS_VIRTUAL]/Data/AxisParameters";
    assert_eq!(
        reported(&import),
        [
            "1 × Controller/Tags/Tag[AXIS_CIP_DRIVE]/Data/AxisParameters/@NewInVersion99: not understood".to_owned(),
            "1 × Controller/Tags/Tag[AXIS_CIP_DRIVE]/Data/AxisParameters/@MotionModule: no counterpart in a configuration"
                .to_owned(),
            "1 × Controller/Tags/Tag[COORDINATE_SYSTEM]: no counterpart in a configuration".to_owned(),
            "1 × Controller/Tags/Tag[COORDINATE_SYSTEM]/Data/CoordinateSystemParameters/@Axes: no counterpart in a \
             configuration"
                .to_owned(),
            format!("1 × {parameters}/@MaximumSpeed: changed: 0 or not given: becomes 100 units/s"),
            format!("1 × {parameters}/@MaximumAcceleration: changed: 0 or not given: becomes 1000 units/s²"),
            format!(
                "1 × {parameters}/@MaximumAccelerationJerk: changed: 0 or not given: becomes acceleration² / speed"
            ),
            "1 × Controller/Tags/Tag[COORDINATE_SYSTEM]/Data/CoordinateSystemParameters/@DynamicsConfigurationBits: \
             changed: of Dynamics Configuration Bits only bits 0 to 2 have a meaning"
                .to_owned(),
        ]
    );
}

#[test]
fn types_tags_values_and_aliases() {
    let import = read(
        r#"<DataTypes>
        <DataType Name="Outer" Family="NoFamily" Class="User"><Members>
            <Member Name="In" DataType="Inner" Dimension="2" Radix="NullType" Hidden="false"/>
            <Member Name="T" DataType="MESSAGE" Dimension="0" Radix="NullType" Hidden="false"/></Members></DataType>
        <DataType Name="Inner" Family="NoFamily" Class="User"><Members>
            <Member Name="ZZZZZZZZZZInner0" DataType="SINT" Dimension="0" Radix="Decimal" Hidden="true"/>
            <Member Name="On" DataType="BIT" Dimension="0" Radix="Decimal" Hidden="false" Target="ZZZZZZZZZZInner0" BitNumber="0"/>
            <Member Name="Speed" DataType="REAL" Dimension="0" Radix="Float" Hidden="false"/></Members></DataType>
        <DataType Name="Str10" Family="StringFamily" Class="User"><Members>
            <Member Name="LEN" DataType="DINT" Dimension="0" Radix="Decimal" Hidden="false"/>
            <Member Name="DATA" DataType="SINT" Dimension="4" Radix="ASCII" Hidden="false"/></Members></DataType>
        </DataTypes><AddOnInstructionDefinitions><AddOnInstructionDefinition Name="Valve"/></AddOnInstructionDefinitions>
        <Tags>
        <Tag Name="Later" TagType="Alias" AliasFor="Other" ExternalAccess="Read Only"/>
        <Tag Name="Other" TagType="Alias" AliasFor="Out.In[1]" ExternalAccess="Read/Write"/>
        <Tag Name="Lamp" TagType="Alias" AliasFor="Local:1:O.Data.0" ExternalAccess="Read/Write"/>
        <Tag Name="Gone" TagType="Alias" AliasFor="Out.T" ExternalAccess="Read/Write"/>
        <Tag Name="Out" TagType="Base" DataType="Outer" Constant="false" ExternalAccess="Read/Write"><Description>x</Description>
            <Data Format="L5K"><![CDATA[[[[1,0.0],[0,0.0]],0]]]></Data><Data Format="Decorated"><Structure DataType="Outer">
            <ArrayMember Name="In" DataType="Inner" Dimensions="2"><Element Index="[0]"><Structure DataType="Inner">
                <DataValueMember Name="On" DataType="BOOL" Value="1"/><DataValueMember Name="Speed" DataType="REAL" Radix="Float" Value="1.5"/>
            </Structure></Element><Element Index="[1]"><Structure DataType="Inner"/></Element></ArrayMember></Structure></Data></Tag>
        <Tag Name="Hex" TagType="Base" DataType="INT" Radix="Hex" Constant="true" ExternalAccess="Read/Write">
            <Data Format="Decorated"><DataValue DataType="INT" Radix="Hex" Value="16#ffff"/></Data></Tag>
        <Tag Name="Text" TagType="Base" DataType="STRING"><Data Format="String" Length="5"><![CDATA['a$'b$N$41']]></Data></Tag>
        <Tag Name="Own" TagType="Base" DataType="Str10"><Data Format="String" Length="2"><![CDATA['ok']]></Data></Tag>
        <Tag Name="Count" TagType="Base" DataType="ALARM_ANALOG"/><Tag Name="Secret" TagType="Base" DataType="DINT" ExternalAccess="None"/>
        <Tag Name="Old" TagType="Base" DataType="DINT"><Data>01 00 00 00</Data></Tag>
        </Tags><Programs><Program Name="Main" Type="Normal"><Tags>
        <Tag Name="Near" TagType="Alias" AliasFor="Hex.3"/><Tag Name="Hex" TagType="Base" DataType="DINT" Dimensions="2,1"/>
        </Tags><Routines><Routine Name="R"/><Routine Name="S"/></Routines></Program></Programs>"#,
    );
    let text = arcline_config::format(&import.config);
    let expected = r#"[server]
name = "Cell"

[[data_type]]
name = "Inner"
members = [{ name = "On", type = "BOOL" }, { name = "Speed", type = "REAL" }]

[[data_type]]
name = "Outer"
members = [{ name = "In", type = "Inner[2]" }]

[[data_type]]
name = "Str10"
members = [{ name = "LEN", type = "DINT" }, { name = "DATA", type = "SINT[4]" }]

[[tag]]
name = "Out"
type = "Outer"
value = { In = [{ On = true, Speed = 1.5 }, {}] }

[[tag]]
name = "Hex"
type = "INT"
access = "read_only"
value = -1

[[tag]]
name = "Text"
type = "STRING"
value = """
a'b
A"""

[[tag]]
name = "Own"
type = "Str10"
value = { DATA = [111, 107, 0, 0], LEN = 2 }

[[tag]]
name = "Old"
type = "DINT"

[[tag]]
name = "Hex"
type = "DINT[2,1]"
program = "Main"

[[tag]]
name = "Later"
access = "read_only"
alias = "Out.In[1]"

[[tag]]
name = "Other"
alias = "Out.In[1]"

[[tag]]
name = "Near"
program = "Main"
alias = "Program:Main.Hex.3"
"#;
    // `Near` stands for a bit of an array, which there is not.
    let expected = expected.replace(
        "\n[[tag]]\nname = \"Near\"\nprogram = \"Main\"\nalias = \"Program:Main.Hex.3\"\n",
        "",
    );
    assert_eq!(text, expected);
    let reported = reported(&import);
    for wanted in [
        "1 × Controller/AddOnInstructionDefinitions/AddOnInstructionDefinition: no counterpart in a configuration",
        "1 × Controller/DataTypes/DataType/Members/Member: no counterpart in a configuration",
        "2 × Controller/Programs/Program/Routines/Routine: no counterpart in a configuration",
        "1 × Controller/Programs/Program/Tags/Tag: no counterpart in a configuration",
        "2 × Controller/Tags/Tag: no counterpart in a configuration",
        "1 × Controller/Tags/Tag[ALARM_ANALOG]: no counterpart in a configuration",
        "1 × Controller/Tags/Tag[DINT]: no counterpart in a configuration",
        "1 × Controller/Tags/Tag[Outer]/Description: no counterpart in a configuration",
        "1 × Controller/DataTypes/DataType: changed: a string type becomes a structure of LEN and DATA",
        "1 × Controller/Tags/Tag[DINT]/Data: changed: a value that is only there as L5K or bytes becomes 0",
    ] {
        assert!(reported.iter().any(|line| line == wanted), "{wanted}\n{reported:#?}");
    }
    assert_eq!(reported.len(), 10, "{reported:#?}");
    let aliases = import
        .report
        .groups()
        .find(|(_, path, _)| *path == "Controller/Tags/Tag");
    let (reason, _, group) = aliases.expect("the aliases that lead out of the tags");
    assert_eq!((reason, group.lines.clone()), (Reason::NoCounterpart, vec![18, 19]));
}

#[test]
fn wrong_files() {
    let deep = format!("{}{}", "<A>".repeat(70), "</A>".repeat(70));
    let wide = format!("<A {}/>", (0..2000).map(|n| format!("a{n}='' ")).collect::<String>());
    #[rustfmt::skip]
    let cases = [
        // why,                      text,                                                     message
        ("nothing",                  String::new(),                                            "x.L5X:1:1: not valid XML"),
        ("no end",                   "<RSLogix5000Content>".to_owned(),                        "x.L5X:1:1: not valid XML"),
        ("another XML",              "<a/>".to_owned(),                                        "x.L5X:1:1: a: found \"a\", expected the element RSLogix5000Content of an L5X file"),
        ("no controller",            "\n <RSLogix5000Content/>".to_owned(),                    "x.L5X:2:2: RSLogix5000Content: Controller is missing"),
        ("a DTD",                    "<!DOCTYPE a [<!ENTITY b \"c\">]><a>&b;</a>".to_owned(),  "x.L5X:1:1: not valid XML"),
        ("an entity",                l5x("&bomb;"),                                            "not valid XML"),
        ("too deep",                 deep,                                                     "x.L5X:1:193: found 65 levels of elements, expected at most 64"),
        ("too wide",                 wide,                                                     "x.L5X:1:1: found 2000 attributes of one element, expected at most 1024"),
        ("no name",                  l5x("<Tags><Tag DataType='DINT'/></Tags>"),               "x.L5X:3:44: Controller/Tags/Tag[DINT]: Name is missing, expected the tag's name"),
        ("no such number of places", l5x("<Tags><Tag Name='A' DataType='DINT' Dimensions='0'/></Tags>"), "@Dimensions: found \"0\", expected up to three whole numbers from 1 to 2147483647"),
        ("a number that is none",    l5x("<Tags><Tag Name='A' DataType='DINT'><Data Format='Decorated'><DataValue Value='x'/></Data></Tag></Tags>"), "DataValue/@Value: found \"x\", expected a whole number that the type holds"),
        ("too large a number",       l5x("<Tags><Tag Name='A' DataType='SINT'><Data Format='Decorated'><DataValue Value='128'/></Data></Tag></Tags>"), "found \"128\", expected a whole number that the type holds"),
        ("too few elements",         l5x("<Tags><Tag Name='A' DataType='SINT' Dimensions='2'><Data Format='Decorated'><Array><Element Value='1'/></Array></Data></Tag></Tags>"), "found \"1 Element\""),
        ("a name twice",             l5x("<Tags><Tag Name='A' DataType='DINT'/>\n<Tag Name='a' DataType='DINT'/></Tags>"), "x.L5X:4:1: Controller/Tags/Tag[DINT]: as a configuration: tag[2].name: the name `a` is taken"),
        ("no word of homing",        l5x("<Tags><Tag Name='A' DataType='AXIS_VIRTUAL'><Data Format='Axis'><AxisParameters HomeSequence='Now'/></Data></Tag></Tags>"), "AxisParameters/@HomeSequence: found \"Now\", expected Immediate"),
        ("a wrong overlay",          l5x("<CustomProperties><Provider ID='Arcline'>= 1</Provider></CustomProperties>"), "expected TOML as Arcline's export writes it"),
    ];
    for (why, text, message) in cases {
        let error = import(&text, "x.L5X").expect_err(why).to_string();
        assert!(error.contains(message), "{why}: {error}");
    }
    let large = " ".repeat(crate::MAX_TEXT + 1);
    let error = import(&large, "x.L5X").expect_err("too large");
    assert!(
        matches!(error.problem, Problem::TooMuch { what: "bytes", .. }),
        "{error}"
    );
}

#[test]
fn a_tag_of_the_default_name_of_the_group_keeps_its_name() {
    let group = |tags: &str| read(&format!("<Tags>{tags}</Tags>")).project.machine.group.clone();
    let tag = "<Tag Name='motion' DataType='DINT'/>";
    assert_eq!(group(tag), "Motion_");
    assert_eq!(
        group(&format!("{tag}<Tag Name='Motion_' DataType='DINT'/>")),
        "Motion__"
    );
    assert_eq!(
        group(&format!("{tag}<Tag Name='Group' DataType='MOTION_GROUP'/>")),
        "Group"
    );
}

#[test]
fn a_circle_of_types_and_of_aliases_ends() {
    let member = |of: &str| format!("<Members><Member Name='M' DataType='{of}'/></Members>");
    let import = read(&format!(
        "<DataTypes><DataType Name='A'>{}</DataType><DataType Name='B'>{}</DataType></DataTypes>\
         <Tags><Tag Name='C' TagType='Alias' AliasFor='D'/><Tag Name='D' TagType='Alias' AliasFor='C'/></Tags>",
        member("B"),
        member("A")
    ));
    assert!(import.project.types.is_empty() && import.project.tags.is_empty());
    assert_eq!(import.report.count(), 6, "{}", import.report);
}

#[test]
fn an_edit_in_studio_wins_where_l5x_has_a_place() {
    let project = arcline_config::load(arcline_config::DEFAULT, "").expect("the default holds");
    let text = export(&project).replacen("MaximumSpeed=\"1000.0\"", "MaximumSpeed=\"750.0\"", 1);
    let import = import(&text, "").expect("an edited file");
    assert_eq!(import.project.machine.axes[0].max_speed, 750.0);
    assert_eq!(import.project.machine.axes[1..], project.machine.axes[1..]);
}

#[test]
fn every_key_of_the_mapping_is_one_of_a_configuration() {
    let page = include_str!("../../../../docs/CONFIGURATION.md");
    for (element, rows) in mapping::ELEMENTS {
        for row in *rows {
            if let mapping::Meaning::Key(keys) = row.meaning {
                for key in keys.split(", ").flat_map(|key| key.split('.')) {
                    let listed = [format!("`{key}`"), format!("[{key}]"), format!("`{key} = ")];
                    assert!(
                        listed.iter().any(|key| page.contains(key)),
                        "{element} {}: {key}",
                        row.what
                    );
                }
            }
        }
    }
}

/// `UPDATE_EXPECT=1` writes the page's table.
#[test]
fn motion_control_tags_of_every_scope_are_there() {
    let tag = |name: &str, more: &str| {
        format!(
            r#"<Tag Name="{name}" TagType="Base" DataType="MOTION_INSTRUCTION"{more} Constant="false" ExternalAccess="Read/Write">
            <Data Format="Decorated"><Structure DataType="MOTION_INSTRUCTION">
            <DataValueMember Name="FLAGS" DataType="DINT" Radix="Hex" Value="16#2000_0000"/></Structure></Data></Tag>"#
        )
    };
    let import = read(&format!(
        r#"<Tags>{}{}<Tag Name="Ready" TagType="Alias" AliasFor="Move1.DN" ExternalAccess="Read/Write"/></Tags><Programs>
        <Program Name="Main"><Tags>{}{}</Tags></Program><Program Name="Other"><Tags>{}</Tags></Program></Programs>"#,
        tag("Move1", ""),
        tag("Many", r#" Dimensions="4""#),
        tag("MOVE1", ""),
        tag("Home1", ""),
        tag("home1", ""),
    ));
    let names: Vec<(&str, bool)> = import
        .project
        .tags
        .iter()
        .map(|tag| (tag.name.as_str(), tag.is_control()))
        .collect();
    assert_eq!(names, [("Move1", true), ("Ready", false), ("Home1", true)]);
    assert_eq!(import.report.count(), 4, "{}", import.report);
    assert!(
        import
            .report
            .to_string()
            .contains("a motion control tag of a program becomes one of the controller")
    );
    assert!(
        import.report.to_string().contains("Tag[MOTION_INSTRUCTION] (Many"),
        "an array is left out by its name: {}",
        import.report
    );
    let again = super::super::import(&export(&import.project), "again").expect("what is written can be read");
    assert_eq!(again.project.tags, import.project.tags);
}

/// As Studio writes them: the word that holds the bits is not among the members, and of a profile there is the Status only.
#[test]
fn predefined_types_of_programs() {
    let import = read(
        r#"<DataTypes><DataType Name="Step" Family="NoFamily" Class="User"><Members>
            <Member Name="Dwell" DataType="TIMER" Dimension="2" Radix="NullType" Hidden="false" ExternalAccess="Read/Write"/>
            <Member Name="Total" DataType="ULINT" Dimension="0" Radix="Decimal" Hidden="false" ExternalAccess="Read/Write"/>
        </Members></DataType></DataTypes><Tags>
        <Tag Name="Wait" TagType="Base" DataType="TIMER" Constant="false" ExternalAccess="Read/Write">
            <Data Format="L5K"><![CDATA[[-2147483648,500,20]]]></Data><Data Format="Decorated"><Structure DataType="TIMER">
            <DataValueMember Name="PRE" DataType="DINT" Radix="Decimal" Value="500"/>
            <DataValueMember Name="ACC" DataType="DINT" Radix="Decimal" Value="20"/>
            <DataValueMember Name="EN" DataType="BOOL" Value="1"/><DataValueMember Name="TT" DataType="BOOL" Value="0"/>
            <DataValueMember Name="DN" DataType="BOOL" Value="0"/></Structure></Data></Tag>
        <Tag Name="Steps" TagType="Base" DataType="Step" Dimensions="3" Constant="false" ExternalAccess="Read/Write"/>
        <Tag Name="Wide" TagType="Base" DataType="ULINT" Radix="Decimal" Constant="false" ExternalAccess="Read/Write">
            <Data Format="Decorated"><DataValue DataType="ULINT" Radix="Decimal" Value="18446744073709551615"/></Data></Tag>
        <Tag Name="Points" TagType="Base" DataType="CAM" Dimensions="1" Constant="false" ExternalAccess="Read/Write">
            <Data Format="Decorated"><Array DataType="CAM" Dimensions="1"><Element Index="[0]"><Structure DataType="CAM">
            <DataValueMember Name="Master" DataType="REAL" Radix="Float" Value="1.5"/>
            <DataValueMember Name="Slave" DataType="REAL" Radix="Float" Value="0.0"/>
            <DataValueMember Name="SegmentType" DataType="DINT" Radix="Decimal" Value="1"/></Structure></Element></Array></Data></Tag>
        <Tag Name="Profile" TagType="Base" DataType="CAM_PROFILE" Dimensions="1" Constant="false" ExternalAccess="Read/Write">
            <Data Format="Decorated"><Array DataType="CAM_PROFILE" Dimensions="1"><Element Index="[0]"><Structure DataType="CAM_PROFILE">
            <DataValueMember Name="Status" DataType="DINT" Radix="Decimal" Value="2"/></Structure></Element></Array></Data></Tag></Tags>"#,
    );
    let text = arcline_config::format(&import.config);
    let expected = r#"[server]
name = "Cell"

[[data_type]]
name = "Step"
members = [{ name = "Dwell", type = "TIMER[2]" }, { name = "Total", type = "ULINT" }]

[[tag]]
name = "Wait"
type = "TIMER"
value = { ACC = 20, EN = true, PRE = 500 }

[[tag]]
name = "Steps"
type = "Step[3]"

[[tag]]
name = "Wide"
type = "ULINT"

[[tag]]
name = "Points"
type = "CAM[1]"
value = [{ Master = 1.5, SegmentType = 1 }]

[[tag]]
name = "Profile"
type = "CAM_PROFILE[1]"
"#;
    assert_eq!(text, expected);
    let profile = "1 × Controller/Tags/Tag[CAM_PROFILE]/Data/Array/Element/Structure/DataValueMember/@Value: changed: a calculated cam \
        profile becomes an empty one, which MCCP fills";
    let wide = "1 × Controller/Tags/Tag[ULINT]/Data/DataValue/@Value: changed: a ULINT of 2^63 or more, for which TOML has no number, \
        becomes 0";
    assert_eq!(reported(&import), [wide, profile]);
}

#[test]
fn the_page_shows_the_mapping() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/L5X.md");
    let page = std::fs::read_to_string(path).expect("docs/L5X.md can be read");
    let (before, table) = page
        .split_once("## Mapping\n")
        .expect("docs/L5X.md has a heading Mapping");
    let expected = mapping::markdown();
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(path, format!("{before}## Mapping\n{expected}")).expect("docs/L5X.md can be written");
    } else {
        assert_eq!(table, expected, "docs/L5X.md is old: UPDATE_EXPECT=1 writes it");
    }
}

#[test]
fn robots() {
    let axis = |name: &str| {
        format!(
            r#"<Tag Name="{name}" TagType="Base" DataType="AXIS_VIRTUAL"><Data Format="Axis">
            <AxisParameters MaximumSpeed="9.0" MaximumAcceleration="8.0" MaximumAccelerationJerk="6.0"/></Data></Tag>"#
        )
    };
    #[rustfmt::skip]
    let cases = [
        // why,                        attributes,                                                     of the configuration, in the report
        ("a delta",                    r#"SystemType="Delta" Axes="J1 J2 J3" TransformDimension="3""#, "delta", ""),
        ("a delta in a plane",         r#"SystemType="Delta" Axes="J1 J2" TransformDimension="2""#, "delta", ""),
        ("an arm",                     r#"SystemType="Articulated Independent" Axes="J1 J2 J3""#, "articulated_independent", ""),
        ("a parallelogram",            r#"SystemType="Articulated Dependent" Axes="J1 J2""#, "articulated_dependent", ""),
        ("a SCARA",                    r#"SystemType="SCARA Independent" Axes="J1 J2 J3""#, "scara_independent", ""),
        ("a SCARA with two arms",      r#"SystemType="SCARA Delta" Axes="J1 J2 J3""#, "scara_delta", ""),
        ("a SCARA without its third",  r#"SystemType="SCARA Independent" Axes="J1 J2""#, "", "@Axes: no counterpart in a configuration"),
        ("a wrist",                    r#"SystemType="Delta" CoordinateDefinition="J1J2J6" Axes="J1 J2 J3""#, "delta", ""),
        ("a wrist without its joint",  r#"SystemType="Delta" CoordinateDefinition="J1J2J3J6" Axes="J1 J2 J3""#, "", "@Axes: no counterpart in a configuration"),
        ("a wrist of another robot",   r#"SystemType="SCARA Delta" CoordinateDefinition="J1J2J6" Axes="J1 J2 J3""#, "", "@CoordinateDefinition: no counterpart in a configuration"),
        ("a robot that is not known",  r#"SystemType="Hexapod" Axes="J1 J2 J3""#, "", "@SystemType: no counterpart in a configuration"),
        ("links of no robot",          r#"SystemType="Cartesian" Axes="J1 J2 J3""#, "cartesian", "@LinkLength1: no counterpart in a configuration"),
        ("a transform of fewer axes",  r#"SystemType="Delta" Axes="J1 J2 J3" TransformDimension="2""#, "delta", "@TransformDimension: changed: transforms take all axes"),
    ];
    for (why, attributes, build, expected) in cases {
        let import = read(&format!(
            r#"<Tags>{}{}{}<Tag Name="R" TagType="Base" DataType="COORDINATE_SYSTEM"><Data Format="CoordinateSystem">
            <CoordinateSystemParameters {attributes} MaximumSpeed="9.0" MaximumAcceleration="8.0" MaximumAccelerationJerk="6.0"
            LinkLength1="100.5" LinkLength2="200.0" ZeroAngleOffset1="1.0" ZeroAngleOffset2="2.0" ZeroAngleOffset3="3.0"
            BaseOffset1="4.0" BaseOffset2="5.0" BaseOffset3="6.0" EndEffectorOffset1="7.0" EndEffectorOffset2="8.0"
            EndEffectorOffset3="-9.0"/></Data></Tag></Tags>"#,
            axis("J1"),
            axis("J2"),
            axis("J3")
        ));
        let lines = reported(&import);
        let told = lines.iter().any(|line| line.ends_with(expected));
        assert!(
            lines.is_empty() == expected.is_empty() && (told || expected.is_empty()),
            "{why}: {lines:#?}"
        );
        let system = import.project.machine.systems.first();
        let robot = system.map(|system| system.robot);
        let found = robot.map(|robot| arcline_config::type_of_system(robot.as_ref()));
        assert_eq!(found.unwrap_or_default(), build, "{why}");
        if let Some(Some(robot)) = robot {
            let parameters = robot.parameters;
            assert_eq!(parameters.link_lengths, [100.5, 200.0], "{why}");
            assert_eq!(parameters.base_offsets, [4.0, 5.0, 6.0], "{why}");
            assert_eq!(parameters.end_effector_offsets, [7.0, 8.0, -9.0], "{why}");
            assert_eq!(parameters.zero_angles[..3], [1.0, 2.0, 3.0], "{why}");
        }
    }
}
