//! Writes the files that an FMU has besides its library: `arcline-fmu FOLDER MACHINE.toml PROGRAM.st [input|output TAG]...`

use std::path::Path;
use std::process::ExitCode;

use arcline_fmu::description::{Description, MACHINE, PROGRAM, TAGS};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match write(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("arcline-fmu: {why}");
            ExitCode::from(2)
        }
    }
}

fn write(arguments: &[String]) -> Result<(), String> {
    let [folder, machine, program, tags @ ..] = arguments else {
        return Err("expected FOLDER MACHINE.toml PROGRAM.st [input|output TAG]...".to_owned());
    };
    let text = |file: &String| std::fs::read_to_string(file).map_err(|error| format!("{file}: {error}"));
    let (machine, program) = (text(machine)?, text(program)?);
    let tags: String = tags.chunks(2).map(|pair| pair.join(" ") + "\n").collect();
    let description = Description::new(&machine, &program, &tags)?;
    let resources = Path::new(folder).join("resources");
    let save =
        |file: &Path, text: &str| std::fs::write(file, text).map_err(|error| format!("{}: {error}", file.display()));
    std::fs::create_dir_all(&resources).map_err(|error| format!("{}: {error}", resources.display()))?;
    save(&resources.join(MACHINE), &machine)?;
    save(&resources.join(PROGRAM), &program)?;
    save(&resources.join(TAGS), &tags)?;
    save(&Path::new(folder).join("modelDescription.xml"), &description.xml())
}
