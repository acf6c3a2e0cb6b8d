//! A trace as columns, as `simulate --trace` and `arcline trace` write it (spec/contract.md §1).

use crate::PlotError;

/// An axis of a trace; a column that the trace does not have is empty.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// Command position, or the actual one when that is all there is; position units.
    pub position: Vec<f64>,
    /// Command velocity, per second.
    pub velocity: Vec<f64>,
    /// Command acceleration, per second².
    pub acceleration: Vec<f64>,
}

/// Columns over time.
#[derive(Clone, PartialEq, Debug)]
pub struct Trace {
    /// Seconds, ascending.
    pub time: Vec<f64>,
    /// In the order of the columns; each has as many values as there are times.
    pub axes: Vec<Axis>,
}

/// The quantity of a column.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Signal {
    Command,
    Actual,
    Velocity,
    Acceleration,
    /// Where the tool of a robot is, along one direction.
    Tool,
}

impl Trace {
    /// Reads CSV with a header. Columns of other signals are passed over. The three of a robot's tool are axes, named as their
    /// columns (`ROBOT.ToolX`), unless the tool is not known throughout.
    ///
    /// # Errors
    /// [`PlotError::Line`] for a row that is no row, [`PlotError::NoAxis`], [`PlotError::Empty`].
    pub fn parse(text: &str) -> Result<Self, PlotError> {
        let mut lines = text.lines().enumerate();
        let (_, header) = lines.next().ok_or(PlotError::Empty)?;
        let titles: Vec<&str> = header.split(',').map(str::trim).collect();
        let wrong = |line: usize, problem: String| PlotError::Line {
            line: line + 1,
            problem,
        };
        let time_column = titles.iter().position(|title| *title == "time_s");
        let time_column = time_column.ok_or_else(|| wrong(0, "no column `time_s`".to_owned()))?;
        let mut axes: Vec<Axis> = Vec::new();
        let mut columns: Vec<Option<(usize, Signal)>> = Vec::new();
        for title in &titles {
            columns.push(column(title).map(|(name, signal)| {
                let known = axes.iter().position(|axis| axis.name == name);
                let place = known.unwrap_or_else(|| {
                    axes.push(Axis {
                        name: name.to_owned(),
                        ..Axis::default()
                    });
                    axes.len() - 1
                });
                (place, signal)
            }));
        }
        let mut actual: Vec<Vec<f64>> = vec![Vec::new(); axes.len()];
        let mut time: Vec<f64> = Vec::new();
        for (line, row) in lines.filter(|(_, row)| !row.trim().is_empty()) {
            let mut count = 0;
            for (place, cell) in row.split(',').enumerate() {
                count += 1;
                let wanted = columns.get(place).copied().flatten();
                if wanted.is_none() && place != time_column {
                    continue;
                }
                let number: f64 = cell
                    .trim()
                    .parse()
                    .ok()
                    .filter(|number: &f64| number.is_finite() || matches!(wanted, Some((_, Signal::Tool))))
                    .ok_or_else(|| {
                        let shown: String = cell.chars().take(30).collect();
                        wrong(line, format!("column {} is {shown:?}, expected a number", place + 1))
                    })?;
                match wanted {
                    None => {
                        if time.last().is_some_and(|last| *last >= number) {
                            return Err(wrong(line, format!("the time {number} does not ascend")));
                        }
                        time.push(number);
                    }
                    Some((axis, signal)) => match signal {
                        Signal::Command | Signal::Tool => axes[axis].position.push(number),
                        Signal::Actual => actual[axis].push(number),
                        Signal::Velocity => axes[axis].velocity.push(number),
                        Signal::Acceleration => axes[axis].acceleration.push(number),
                    },
                }
            }
            if count != titles.len() {
                return Err(wrong(line, format!("{count} columns, the header has {}", titles.len())));
            }
        }
        for (axis, actual) in axes.iter_mut().zip(actual) {
            if axis.position.is_empty() {
                axis.position = actual;
            }
        }
        axes.retain(|axis| !axis.position.is_empty() && axis.position.iter().all(|at| at.is_finite()));
        if time.len() < 2 {
            return Err(PlotError::Empty);
        }
        if axes.is_empty() {
            return Err(PlotError::NoAxis);
        }
        for axis in &mut axes {
            if axis.velocity.is_empty() {
                axis.velocity = differences(&time, &axis.position);
            }
            if axis.acceleration.is_empty() {
                axis.acceleration = differences(&time, &axis.velocity);
            }
        }
        Ok(Self { time, axes })
    }

    /// The directions in which the tool of a robot moves: of the first one whose tool does.
    pub fn tool(&self) -> Option<Vec<&Axis>> {
        let moving = self.axes.iter().filter(|axis| axis.moves());
        let tools = moving.filter_map(|axis| Some((axis.robot()?, axis)));
        let (first, _) = tools.clone().next()?;
        Some(
            tools
                .filter(|(robot, _)| *robot == first)
                .map(|(_, axis)| axis)
                .collect(),
        )
    }

    /// The axes that move, or the first when none does.
    pub fn moving(&self) -> Vec<&Axis> {
        let moving: Vec<&Axis> = self.axes.iter().filter(|axis| axis.moves()).collect();
        if moving.is_empty() {
            self.axes.iter().take(1).collect()
        } else {
            moving
        }
    }
}

impl Axis {
    /// The robot whose tool it is.
    fn robot(&self) -> Option<&str> {
        let (robot, signal) = self.name.rsplit_once('.')?;
        TOOL.contains(&signal).then_some(robot)
    }

    fn moves(&self) -> bool {
        self.position.iter().any(|at| (at - self.position[0]).abs() > 1e-9)
    }

    /// Per second³: the change of the acceleration between two rows.
    pub fn jerk(&self, time: &[f64]) -> Vec<f64> {
        differences(time, &self.acceleration)
    }
}

/// The columns of a robot's tool.
const TOOL: [&str; 3] = ["ToolX", "ToolY", "ToolZ"];

/// The name of the axis and the quantity of the column.
fn column(title: &str) -> Option<(&str, Signal)> {
    let (name, signal) = title.rsplit_once('.')?;
    if TOOL.contains(&signal) {
        return Some((title, Signal::Tool));
    }
    let signal = match signal {
        "CommandPosition" => Signal::Command,
        "ActualPosition" => Signal::Actual,
        "CommandVelocity" => Signal::Velocity,
        "CommandAcceleration" => Signal::Acceleration,
        _ => return None,
    };
    Some((name, signal))
}

/// The rate of change up to each row; as long as the values, the first 0.
fn differences(time: &[f64], values: &[f64]) -> Vec<f64> {
    let steps = time.windows(2).zip(values.windows(2));
    let rates = steps.map(|(time, values)| (values[1] - values[0]) / (time[1] - time[0]));
    std::iter::once(0.0).chain(rates).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name() {
        let text = "tick,time_s,X.CommandPosition,X.CommandVelocity,X.CommandAcceleration,X.ActualPosition,Y.ActualPosition,CS1.Speed\n\
                    0,0,1,2,3,4,5,6\n1,0.5,2,3,5,5,7,8\n";
        let trace = Trace::parse(text).expect("a trace");
        assert_eq!(trace.time, [0.0, 0.5]);
        let [x, y] = trace.axes.as_slice() else {
            panic!("{trace:?}")
        };
        assert_eq!(
            (x.name.as_str(), x.position.as_slice(), x.velocity.as_slice()),
            ("X", &[1.0, 2.0][..], &[2.0, 3.0][..])
        );
        assert_eq!(x.jerk(&trace.time), [0.0, 4.0]);
        assert_eq!((y.name.as_str(), y.position.as_slice()), ("Y", &[5.0, 7.0][..]));
        assert_eq!(y.velocity, [0.0, 4.0], "by differences");
    }

    #[test]
    fn a_tool_is_three_axes_where_it_is_known() {
        let head = "tick,time_s,J1.CommandPosition,R.ToolX,R.ToolY,R.ToolZ,Q.ToolX";
        let trace = Trace::parse(&format!("{head}\n0,0,1,2,3,4,NaN\n1,0.5,1,3,3,6,1\n")).expect("a trace");
        let names = |axes: &[&Axis]| axes.iter().map(|axis| axis.name.clone()).collect::<Vec<_>>();
        let all: Vec<&Axis> = trace.axes.iter().collect();
        assert_eq!(
            names(&all),
            ["J1", "R.ToolX", "R.ToolY", "R.ToolZ"],
            "that of Q is not known"
        );
        assert_eq!(names(&trace.tool().expect("a tool")), ["R.ToolX", "R.ToolZ"]);
        assert_eq!(trace.axes[3].velocity, [0.0, 4.0]);
        let still = Trace::parse(&format!("{head}\n0,0,1,2,3,4,5\n1,0.5,1,2,3,4,5\n")).expect("a trace");
        assert_eq!(still.tool(), None);
    }

    #[test]
    fn files_that_are_no_trace_are_reported() {
        let head = "tick,time_s,X.CommandPosition\n";
        #[rustfmt::skip]
        let cases = [
            ("nothing",          String::new(),                            "fewer than two rows"),
            ("no time",          "tick,X.CommandPosition\n0,0\n".into(),   "line 1: no column `time_s`"),
            ("no axis",          "tick,time_s\n0,0\n1,1\n".into(),         "no column `NAME.CommandPosition`"),
            ("one row",          format!("{head}0,0,0\n"),                 "fewer than two rows"),
            ("a short row",      format!("{head}0,0,0\n1,1\n"),            "line 3: 2 columns, the header has 3"),
            ("a long row",       format!("{head}0,0,0,0\n"),               "line 2: 4 columns, the header has 3"),
            ("no number",        format!("{head}0,0,x\n"),                 "line 2: column 3 is \"x\", expected a number"),
            ("not finite",       format!("{head}0,0,NaN\n"),               "line 2: column 3"),
            ("time stands",      format!("{head}0,0,0\n1,0,0\n"),          "line 3: the time 0 does not ascend"),
        ];
        for (why, text, expected) in cases {
            let error = Trace::parse(&text).expect_err(why).to_string();
            assert!(error.contains(expected), "{why}: {error}");
        }
    }
}
