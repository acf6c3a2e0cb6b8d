//! The screen of `watch`: tables of the machine, and beside or below them, where there is room, the path of one coordinate system.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{Canvas, Points};
use ratatui::widgets::{Block, Cell, Paragraph, Row, Sparkline, Table};

use crate::cli::status::{Kind, ObjectStatus};

use super::INHIBITED;
use super::view::View;

/// A path is drawn beside the tables on screens at least so wide, columns.
const WIDE: u16 = 120;
/// Columns of the tables on a wide screen.
const TABLES: u16 = 84;
/// The fewest free rows below the tables in which a path is drawn.
const TALL: u16 = 12;
/// A character is about twice as high as wide.
const ASPECT: f64 = 2.0;

/// Draws everything.
pub(super) fn draw(view: &View, frame: &mut Frame<'_>) {
    let (above, movers) = (held(view), movers(view));
    let [first, last] = [above.len(), movers.len()].map(|lines| Constraint::Length(lines as u16));
    let areas = Layout::vertical([first, Constraint::Min(0), last, Constraint::Length(1)]);
    let [head, body, below, foot] = areas.areas(frame.area());
    frame.render_widget(Paragraph::new(above), head);
    frame.render_widget(Paragraph::new(movers), below);
    frame.render_widget(keys(view), foot);
    if body.width >= WIDE {
        let [left, right] = Layout::horizontal([Constraint::Length(TABLES), Constraint::Min(0)]).areas(body);
        tables(view, frame, left);
        let [path_area, speed_area] = Layout::vertical([Constraint::Min(0), Constraint::Length(6)]).areas(right);
        path(view, frame, path_area);
        speed(view, frame, speed_area);
        return;
    }
    let of_tables: u16 = groups(view).iter().map(|(_, shown)| rows(shown)).sum();
    if body.height < of_tables + TALL {
        tables(view, frame, body);
        return;
    }
    let [above, below] = Layout::vertical([Constraint::Length(of_tables), Constraint::Min(0)]).areas(body);
    tables(view, frame, above);
    path(view, frame, below);
}

/// A line while STOP holds.
fn held(view: &View) -> Vec<Line<'_>> {
    let style = Style::new()
        .fg(Color::White)
        .bg(Color::Red)
        .add_modifier(Modifier::BOLD);
    let line = view.is_inhibited.then(|| Line::styled(INHIBITED, style));
    line.into_iter().collect()
}

/// A line for each mover.
fn movers(view: &View) -> Vec<Line<'_>> {
    let line = |(mover, names): (&str, String)| Line::from(format!("{names}: moved by {mover}"));
    view.movers().into_iter().map(line).collect()
}

fn keys(view: &View) -> Line<'_> {
    let state = if view.paused { "paused" } else { "live" };
    let bold = Style::new().add_modifier(Modifier::BOLD);
    Line::from(vec![
        Span::styled(format!("{state} {:.1} s  ", view.time), bold),
        Span::raw("q end  s stop all  p pause  c clear  Tab next system  "),
        Span::styled(view.note.as_str(), Style::new().fg(Color::Yellow)),
    ])
}

/// The objects by kind, a table for each.
fn groups(view: &View) -> Vec<(Kind, Vec<&ObjectStatus>)> {
    Kind::ALL
        .into_iter()
        .map(|kind| {
            (
                kind,
                view.shown.iter().filter(|one| one.kind == kind).collect::<Vec<_>>(),
            )
        })
        .filter(|(_, shown)| !shown.is_empty())
        .collect()
}

/// Rows of a table: with its titles, and one below it.
fn rows(shown: &[&ObjectStatus]) -> u16 {
    shown.len() as u16 + 2
}

fn tables(view: &View, frame: &mut Frame<'_>, area: Rect) {
    let groups = groups(view);
    let heights = groups.iter().map(|(_, shown)| Constraint::Length(rows(shown)));
    for ((kind, shown), area) in groups.iter().zip(Layout::vertical(heights).split(area).iter()) {
        frame.render_widget(objects(*kind, shown), *area);
    }
}

fn objects<'a>(kind: Kind, shown: &[&'a ObjectStatus]) -> Table<'a> {
    let titles = kind.header();
    let widths = titles.iter().enumerate().map(|(column, title)| {
        let cells = shown.iter().filter_map(|one| one.row.get(column));
        let width = cells
            .map(|cell| cell.chars().count())
            .chain([title.chars().count()])
            .max();
        Constraint::Length(width.unwrap_or_default() as u16)
    });
    let rows = shown.iter().map(|one| {
        let cells = one.row.iter().enumerate().map(|(column, text)| {
            let width = titles.get(column).map_or(0, |title| title.chars().count());
            let longest = shown
                .iter()
                .filter_map(|one| one.row.get(column))
                .map(|cell| cell.chars().count());
            let width = longest.chain([width]).max().unwrap_or_default();
            // Numbers to the right, as in `status`.
            let text = if text.parse::<f64>().is_ok() {
                format!("{text:>width$}")
            } else {
                text.clone()
            };
            Cell::from(text).style(colour(kind, titles.get(column).copied(), one))
        });
        Row::new(cells.collect::<Vec<_>>())
    });
    let header = Row::new(titles.iter().copied()).style(Style::new().add_modifier(Modifier::BOLD));
    Table::new(rows.collect::<Vec<_>>(), widths.collect::<Vec<_>>())
        .header(header)
        .column_spacing(2)
}

/// The last column is the state: green in motion, red with a fault.
fn colour(kind: Kind, title: Option<&str>, one: &ObjectStatus) -> Style {
    if title != kind.header().last().copied() {
        return Style::new();
    }
    let state = one.row.last().map_or("", String::as_str);
    let is_faulted = one.object["faults"].as_array().is_some_and(|faults| !faults.is_empty());
    if is_faulted || state.contains("shutdown") {
        Style::new().fg(Color::Red)
    } else if matches!(kind, Kind::Axis | Kind::System) && state != "at rest" {
        Style::new().fg(Color::Green)
    } else {
        Style::new()
    }
}

/// The trail of the first two axes, in the same scale both ways.
fn path(view: &View, frame: &mut Frame<'_>, area: Rect) {
    let title = view
        .system()
        .map_or("no coordinate system", |system| system.name.as_str());
    let block = Block::bordered().title(format!(" {title}: the way so far "));
    let trail = view.trail();
    let Some((x, y)) = bounds(&trail, block.inner(area)) else {
        frame.render_widget(block, area);
        return;
    };
    let canvas = Canvas::default()
        .block(block)
        .marker(Marker::Braille)
        .x_bounds(x)
        .y_bounds(y)
        .paint(|context| {
            context.draw(&Points::new(&trail, Color::Cyan));
            if let Some((x, y)) = trail.last() {
                context.print(*x, *y, Span::styled("●", Style::new().fg(Color::Yellow)));
            }
        });
    frame.render_widget(canvas, area);
}

/// Bounds that hold all points with a margin, as wide and high as the area asks for.
fn bounds(points: &[(f64, f64)], area: Rect) -> Option<([f64; 2], [f64; 2])> {
    let (first, rest) = points.split_first()?;
    let start = ([first.0, first.0], [first.1, first.1]);
    let (x, y) = rest.iter().fold(start, |(x, y), (px, py)| {
        ([x[0].min(*px), x[1].max(*px)], [y[0].min(*py), y[1].max(*py)])
    });
    let (width, height) = (f64::from(area.width.max(1)), ASPECT * f64::from(area.height.max(1)));
    // Units for one column.
    let unit = ((x[1] - x[0]) / width).max((y[1] - y[0]) / height).max(1e-3) * 1.1;
    let around = |range: [f64; 2], size: f64| {
        let middle = 0.5 * (range[0] + range[1]);
        [middle - 0.5 * size * unit, middle + 0.5 * size * unit]
    };
    Some((around(x, width), around(y, height)))
}

fn speed(view: &View, frame: &mut Frame<'_>, area: Rect) {
    let speeds = view.speeds(usize::from(area.width.saturating_sub(2)));
    let top = speeds.iter().copied().fold(0.0, f64::max);
    let now = speeds.last().copied().unwrap_or_default();
    let block = Block::bordered().title(format!(" path speed {now:.1}, highest {top:.1} "));
    if speeds.is_empty() {
        frame.render_widget(Paragraph::new("").block(block), area);
        return;
    }
    // A bar has a whole number; a thousandth of a unit is finer than a screen.
    let bars: Vec<u64> = speeds.iter().map(|speed| (speed * 1e3) as u64).collect();
    let line = Sparkline::default()
        .block(block)
        .data(bars)
        .style(Style::new().fg(Color::Cyan));
    frame.render_widget(line, area);
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;
    use serde_json::json;

    fn system(position: [f64; 3], state: &str) -> ObjectStatus {
        ObjectStatus {
            kind: Kind::System,
            name: "CS1".to_owned(),
            row: vec![
                "CS1".to_owned(),
                format!("{position:?}"),
                "none".to_owned(),
                state.to_owned(),
            ],
            object: json!({"faults": []}),
            mover: None,
            position: position.to_vec(),
        }
    }

    fn axis(name: &str, position: f64) -> ObjectStatus {
        let row = [
            name,
            &format!("{position:.3}"),
            "0.000",
            "0.000",
            "on",
            "yes",
            "at rest",
        ];
        ObjectStatus {
            kind: Kind::Axis,
            name: name.to_owned(),
            row: row.map(str::to_owned).to_vec(),
            object: json!({"faults": []}),
            mover: None,
            position: vec![position],
        }
    }

    fn drawn(view: &View, width: u16, height: u16) -> String {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).expect("a screen in memory");
        terminal.draw(|frame| draw(view, frame)).expect("it can be drawn on");
        let buffer = terminal.backend().buffer().clone();
        let rows = buffer.content().chunks(usize::from(width));
        rows.map(|row| row.iter().map(|cell| cell.symbol()).collect::<String>() + "\n")
            .collect()
    }

    #[test]
    fn the_screen_shows_the_machine_and_the_way() {
        let mut view = View::new();
        for step in 0..=50 {
            let x = f64::from(step) * 2.0;
            view.take(
                vec![axis("X", x), axis("Long", -20.0), system([x, x, 0.0], "moving")],
                x / 50.0,
            );
        }
        let wide = drawn(&view, 160, 30);
        for expected in [
            "axis",
            "Long",
            "-20.000",
            "CS1: the way so far",
            "●",
            "path speed 70.7",
            "s stop all",
        ] {
            assert!(wide.contains(expected), "{expected}:\n{wide}");
        }
        // A line from corner to corner leaves dots in most rows of the canvas.
        let rows = wide
            .lines()
            .filter(|line| line.chars().any(|c| ('\u{2801}'..='\u{28ff}').contains(&c)));
        assert!(rows.count() > 8, "{wide}");
        for (height, is_drawn) in [(24, true), (18, false)] {
            let narrow = drawn(&view, 80, height);
            assert!(
                narrow.contains("moving") && narrow.contains("the way so far") == is_drawn,
                "{narrow}"
            );
        }
        // However small, nothing panics.
        for (width, height) in [(1, 1), (10, 2), (121, 3), (200, 1)] {
            let _ = drawn(&view, width, height);
        }
        view.clear();
        assert!(!drawn(&view, 160, 30).contains('●'));
    }

    #[test]
    fn the_screen_shows_a_stop_that_holds_and_each_mover() {
        let moved = |name, mover: &str| ObjectStatus {
            mover: Some(mover.to_owned()),
            ..axis(name, 0.0)
        };
        let mut view = View::new();
        let shown = vec![
            moved("X", "10.0.0.5:50123 (pycomm3)"),
            axis("Y", 0.0),
            moved("Z", "10.0.0.5:50123 (pycomm3)"),
            moved("A", "the program of 10.0.0.7 #3 (Firefox 128), line 7"),
        ];
        view.take(shown, 0.0);
        for (width, height) in [(80, 24), (160, 30)] {
            view.is_inhibited = false;
            let text = drawn(&view, width, height);
            assert!(!text.contains("STOP holds"), "{text}");
            for line in [
                "X Z: moved by 10.0.0.5:50123 (pycomm3)",
                "A: moved by the program of 10.0.0.7 #3 (Firefox 128), line 7",
            ] {
                assert!(text.lines().any(|found| found.trim_end() == line), "{line}:\n{text}");
            }
            view.is_inhibited = true;
            let text = drawn(&view, width, height);
            assert!(text.starts_with("STOP holds: motion is inhibited"), "{text}");
        }
    }

    #[test]
    fn columns_stay_in_line() {
        let mut view = View::new();
        view.take(vec![axis("X", 1.5), axis("Y", -1234.5)], 0.0);
        let text = drawn(&view, 80, 6);
        assert!(text.contains("X         1.500"), "{text}");
        assert!(text.contains("Y     -1234.500"), "{text}");
    }
}
