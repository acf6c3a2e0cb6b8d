//! `plot`: a picture of a trace, drawn by `arcline-plot`.

use std::path::Path;

use serde_json::json;

use arcline_plot::{Mark, Options, PlotError, Trace, png, svg};

use super::args::Plot;
use super::output::counted;
use super::{Failure, Output};

/// `plot`.
pub(crate) fn plot(command: &Plot, output: &Output) -> Result<(), Failure> {
    let Plot {
        trace,
        output: target,
        events,
        axes,
        title,
        scale,
    } = command;
    let is_png = match target.extension().and_then(|ending| ending.to_str()) {
        Some(ending) if ending.eq_ignore_ascii_case("svg") => false,
        Some(ending) if ending.eq_ignore_ascii_case("png") => true,
        _ => {
            let shown = target.display();
            return Err(Failure::Usage(format!("{shown} ends neither in .svg nor in .png")));
        }
    };
    let wrong = |path: &Path| {
        let path = path.display().to_string();
        move |source: PlotError| Failure::Plot { path, source }
    };
    let read = |path: &Path| std::fs::read_to_string(path).map_err(|source| Failure::at(path, source));
    let is_mcap = trace
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"));
    let bytes = std::fs::read(trace).map_err(|source| Failure::at(trace, source))?;
    let Some(text) = String::from_utf8(bytes).ok().filter(|_| !is_mcap) else {
        let shown = trace.display();
        return Err(Failure::Usage(format!(
            "{shown} is no CSV: plot reads traces in CSV only, such as `arcline trace -o OUT.csv` writes"
        )));
    };
    let columns = Trace::parse(&text).map_err(wrong(trace))?;
    let marks = match events {
        Some(events) => Mark::parse(&read(events)?).map_err(wrong(events))?,
        None => Vec::new(),
    };
    let options = Options {
        axes: axes.clone(),
        marks,
        title: title.clone(),
    };
    let picture = svg(&columns, &options).map_err(wrong(trace))?;
    let bytes = if is_png {
        png(&picture, *scale).map_err(wrong(target))?
    } else {
        picture.into_bytes()
    };
    std::fs::write(target, bytes).map_err(|source| Failure::at(target, source))?;
    let shown = target.display().to_string();
    let rows = columns.time.len();
    output.result(
        format!("{shown}: {} drawn", counted(rows, "row")),
        || json!({"picture": shown, "rows": rows}),
    );
    Ok(())
}
