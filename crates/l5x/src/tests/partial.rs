//! Partial exports: the parts that run.

use arcline_routine::source::Trigger;

use crate::logic;

fn file(target: &str, name: &str, inside: &str) -> String {
    format!(
        "<RSLogix5000Content SchemaRevision=\"1.0\" TargetName=\"{name}\" TargetType=\"{target}\" ContainsContext=\"true\">\
         <Controller Use=\"Context\" Name=\"Cell\">{inside}</Controller></RSLogix5000Content>"
    )
}

const ADD_ON: &str = r#"<AddOnInstructionDefinitions Use="Context"><AddOnInstructionDefinition Name="Other"><Parameters/><Routines/></AddOnInstructionDefinition>
<AddOnInstructionDefinition Use="Target" Name="Scale"><Parameters>
<Parameter Name="EnableIn" DataType="BOOL" Usage="Input" Required="false"/>
<Parameter Name="In" DataType="DINT" Usage="Input" Required="true"/>
<Parameter Name="Arr" DataType="REAL" Dimensions="4" Usage="InOut" Required="true"/>
<Parameter Name="Hidden" DataType="DINT" Usage="Output" Required="false"/>
<Parameter Name="Out" DataType="REAL" Usage="Output" Required="true"/></Parameters><Routines/></AddOnInstructionDefinition></AddOnInstructionDefinitions>
<Tags Use="Context"><Tag Name="in" TagType="Base" DataType="BOOL"/></Tags>"#;

const ROUTINES: &str = r#"<Programs Use="Context"><Program Use="Context" Name="First"><Routines><Routine Name="Sub" Type="RLL"/></Routines></Program>
<Program Use="Context" Name="Main" MainRoutineName="Go"><Routines Use="Context"><Routine Use="Context" Name="Go" Type="RLL"/>
<Routine Use="Context" Name="Sub" Type="RLL"><RLLContent Use="Context"><Rung Use="Target" Number="0" Type="N"><Text>NOP();</Text></Rung></RLLContent></Routine>
</Routines></Program></Programs>"#;

#[test]
fn an_add_on_instruction_alone_is_called_in_every_scan() {
    let project = logic(&file("AddOnInstructionDefinition", "Scale", ADD_ON), "scale.L5X").expect("it is read");
    let tags: Vec<_> = project
        .tags
        .iter()
        .map(|tag| (tag.name.as_str(), tag.data_type.as_str(), tag.dimensions.len()))
        .collect();
    let expected = [
        ("in", "BOOL", 0),
        ("Scale1", "Scale", 0),
        ("In_", "DINT", 0),
        ("Arr", "REAL", 1),
        ("Out", "REAL", 0),
    ];
    assert_eq!(tags, expected, "a name that is taken gets an underscore");
    let arcline_routine::source::Content::Ladder(rungs) = &project.programs[0].routines[0].content else {
        panic!("{:?}", project.programs)
    };
    assert_eq!(rungs[0].text, "Scale(Scale1,In_,Arr,Out);");
    assert_eq!(project.tasks[0].trigger, Trigger::Periodic(10.0));
    assert_eq!(project.tasks[0].programs, ["Trial"]);
}

#[test]
fn a_parameter_that_is_an_alias_is_an_operand_of_its_own() {
    let alias = "<Parameter Name=\"Go\" TagType=\"Alias\" AliasFor=\"Own.2\" Usage=\"Input\" Required=\"true\"/><Parameter Name=\"Out\"";
    let add_on = ADD_ON.replace("<Parameter Name=\"Out\"", alias);
    let local = "</Parameters><LocalTags><LocalTag Name=\"Own\" DataType=\"DINT\"/></LocalTags><Routines/></AddOnInstructionDefinition></Add";
    let add_on = add_on.replace("</Parameters><Routines/></AddOnInstructionDefinition></Add", local);
    let project = logic(&file("AddOnInstructionDefinition", "Scale", &add_on), "scale.L5X").expect("it is read");
    let arcline_routine::source::Content::Ladder(rungs) = &project.programs[0].routines[0].content else {
        panic!("{:?}", project.programs)
    };
    assert_eq!(rungs[0].text, "Scale(Scale1,In_,Arr,Scale1.Go,Out);");
    assert!(project.tags.iter().all(|tag| tag.name != "Go"), "{:?}", project.tags);
    let loaded = arcline_routine::load(&project, &mut arcline_routine::NoMachine);
    assert!(loaded.findings.is_empty(), "{:?}", loaded.findings);
}

#[test]
fn an_operand_of_the_default_name_of_the_motion_group_gets_an_underscore() {
    let add_on = ADD_ON.replace("Name=\"Arr\"", "Name=\"Motion\"");
    let project = logic(&file("AddOnInstructionDefinition", "Scale", &add_on), "scale.L5X").expect("it is read");
    assert!(
        project.tags.iter().any(|tag| tag.name == "Motion_"),
        "{:?}",
        project.tags
    );
}

#[test]
fn what_an_export_only_names_is_not_in_it() {
    let inside = ROUTINES.replace(
        "<Routines Use=\"Context\">",
        "<Tags Use=\"Context\"><Tag Use=\"Reference\" Name=\"Hmi\"/></Tags><Routines Use=\"Context\">\
         <Routine Use=\"Reference\" Name=\"Named\"/><Routine Use=\"Reference\" Name=\"Called\"/>",
    );
    let inside = inside.replace("NOP();", "JSR(called,0);");
    let text = file("Rung", "Sub", &inside);
    let project = logic(&text, "part.L5X").expect("it is read");
    let main = &project.programs[1];
    assert!(main.tags.is_empty(), "{:?}", main.tags);
    let names: Vec<_> = main.routines.iter().map(|one| one.name.as_str()).collect();
    assert_eq!(names, ["Called", "Go", "Sub"]);
    crate::import(&text, "part.L5X").expect("a configuration");
}

#[test]
fn the_target_of_a_partial_export_runs() {
    let of_program = ROUTINES.replace("Use=\"Context\" Name=\"Main\"", "Use=\"Target\" Name=\"Main\"");
    let of_routine = ROUTINES.replace("Use=\"Context\" Name=\"Sub\"", "Use=\"Target\" Name=\"Sub\"");
    #[rustfmt::skip]
    let cases = [
        ("a program",        "Program",    of_program.as_str(), Some(("Main", "Go"))),
        ("a routine",        "Routine",    of_routine.as_str(), Some(("Main", "Sub"))),
        ("rungs",            "Rung",       ROUTINES,            Some(("Main", "Sub"))),
        ("a data type",      "DataType",   ROUTINES,            None),
        ("no target",        "Program",    ROUTINES,            None),
        ("a whole project",  "Controller", ROUTINES,            None),
    ];
    for (why, target, inside, expected) in cases {
        let project = logic(&file(target, "Sub", inside), "part.L5X").expect(why);
        let found = project.tasks.first().map(|task| {
            let program = project.programs.iter().find(|one| one.name == task.programs[0]);
            let program = program.expect("the task's program");
            (program.name.as_str(), program.main.as_deref().unwrap_or_default())
        });
        assert_eq!(found, expected, "{why}");
    }
}
