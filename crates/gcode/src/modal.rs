//! The modal state from line to line, and the effect of a line: first the modes, then the dwell, then the motion.

use crate::arc::Arc;
use crate::tolerance::{NO_MOTION_MM, STRAIGHT_ARC_MM};
use crate::words::Word;
use crate::{Corner, GcodeError, Motion, Options, Problem, Speed};

const MM_PER_INCH: f64 = 25.4;
const SECONDS_PER_MINUTE: f64 = 60.0;

/// The modal state.
#[derive(Debug)]
pub(crate) struct Modes {
    skip: Vec<String>,
    axes: usize,
    /// One millimetre in units of the machine.
    mm: f64,
    /// One unit of the program in units of the machine.
    scale: f64,
    is_absolute: bool,
    is_center_absolute: bool,
    plane: Plane,
    motion: Option<MotionMode>,
    corner: Corner,
    /// Units of the machine per second.
    feed: Option<f64>,
    position: [f64; 3],
}

#[derive(Clone, Copy, PartialEq, Debug)]
enum MotionMode {
    Rapid,
    Line,
    Arc { is_ccw: bool },
}

/// The axes of a plane, the first turning to the second counterclockwise, seen from the third's positive side.
#[derive(Clone, Copy, PartialEq, Debug)]
struct Plane([usize; 3]);

/// The effect of a G word.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Meaning {
    Motion(Option<MotionMode>),
    Dwell,
    Plane(Plane),
    Inches(bool),
    Corner(Corner),
    Absolute(bool),
    CenterAbsolute(bool),
    /// The only supported state, without effect.
    Nothing,
}

/// Every G word: its number times ten, its group, its meaning. Two of a group exclude each other on a line.
#[rustfmt::skip]
const G_WORDS: &[(u16, u8, Meaning)] = &[
    (0, 1, Meaning::Motion(Some(MotionMode::Rapid))),
    (10, 1, Meaning::Motion(Some(MotionMode::Line))),
    (20, 1, Meaning::Motion(Some(MotionMode::Arc { is_ccw: false }))),
    (30, 1, Meaning::Motion(Some(MotionMode::Arc { is_ccw: true }))),
    (40, 0, Meaning::Dwell),
    (170, 2, Meaning::Plane(Plane([0, 1, 2]))),
    (180, 2, Meaning::Plane(Plane([2, 0, 1]))),
    (190, 2, Meaning::Plane(Plane([1, 2, 0]))),
    (200, 6, Meaning::Inches(true)),
    (210, 6, Meaning::Inches(false)),
    (400, 7, Meaning::Nothing),
    (490, 8, Meaning::Nothing),
    (540, 12, Meaning::Nothing),
    (610, 13, Meaning::Corner(Corner::Exact)),
    (611, 13, Meaning::Corner(Corner::Stop)),
    (640, 13, Meaning::Corner(Corner::Rounded)),
    (800, 1, Meaning::Motion(None)),
    (900, 3, Meaning::Absolute(true)),
    (901, 4, Meaning::CenterAbsolute(true)),
    (910, 3, Meaning::Absolute(false)),
    (911, 4, Meaning::CenterAbsolute(false)),
    (940, 5, Meaning::Nothing),
];
/// M words: the end.
const M_WORDS: [u16; 2] = [2, 30];
const AXES: [char; 3] = ['X', 'Y', 'Z'];
const OFFSETS: [char; 3] = ['I', 'J', 'K'];

impl Modes {
    pub(crate) fn new(options: &Options) -> Self {
        let mm = if options.inches { MM_PER_INCH.recip() } else { 1.0 };
        Self {
            skip: options.skip.iter().map(|word| word.to_ascii_uppercase()).collect(),
            axes: options.axes.clamp(1, 3),
            mm,
            scale: mm,
            is_absolute: true,
            is_center_absolute: false,
            plane: Plane([0, 1, 2]),
            motion: None,
            corner: Corner::Exact,
            feed: None,
            position: options.start,
        }
    }

    /// Executes the words of a line. Returns whether the program continues behind it.
    pub(crate) fn line(
        &mut self,
        words: &[Word],
        line: usize,
        then: &mut dyn FnMut(Motion),
    ) -> Result<bool, GcodeError> {
        let line = Line::new(words, line, &self.skip)?;
        for (meaning, _) in &line.meanings {
            match *meaning {
                Meaning::Motion(motion) => self.motion = motion,
                Meaning::Plane(plane) => self.plane = plane,
                Meaning::Inches(true) => self.scale = self.mm * MM_PER_INCH,
                Meaning::Inches(false) => self.scale = self.mm,
                Meaning::Absolute(absolute) => self.is_absolute = absolute,
                Meaning::CenterAbsolute(absolute) => self.is_center_absolute = absolute,
                Meaning::Corner(corner) => self.corner = corner,
                Meaning::Dwell | Meaning::Nothing => {}
            }
        }
        if let Some(feed) = line.word('F') {
            if feed.value < 0.0 {
                return Err(line.value(feed, "0 or more"));
            }
            self.feed = Some(feed.value * self.scale / SECONDS_PER_MINUTE);
        }
        self.use_p(&line, then)?;
        self.travel(&line, then)?;
        Ok(!line.is_end)
    }

    /// P is the time of a dwell, or the tolerance of G64.
    fn use_p(&mut self, line: &Line<'_>, then: &mut dyn FnMut(Motion)) -> Result<(), GcodeError> {
        let dwell = line.meanings.iter().find(|(meaning, _)| *meaning == Meaning::Dwell);
        let rounded = line
            .meanings
            .iter()
            .find(|(meaning, _)| *meaning == Meaning::Corner(Corner::Rounded));
        let p = line.word('P');
        match (dwell, rounded, p) {
            (Some((_, dwell)), Some((_, rounded)), Some(_)) => Err(line.exclude(dwell, rounded)),
            (Some((_, dwell)), _, None) => Err(line.missing(dwell.column, "the time of the dwell", "P and seconds")),
            (_, _, Some(p)) if p.value < 0.0 => Err(line.value(p, "0 or more")),
            (Some(_), _, Some(p)) => {
                then(Motion::Dwell { seconds: p.value });
                Ok(())
            }
            (None, Some(_), Some(p)) => {
                // Nothing may be cut off: the exact path.
                self.corner = if p.value == 0.0 {
                    Corner::Exact
                } else {
                    Corner::Within(p.value * self.scale)
                };
                Ok(())
            }
            (None, None, Some(p)) => Err(line.unused(p, "P is the time of G4 or the tolerance of G64")),
            (None, _, None) => Ok(()),
        }
    }

    fn travel(&mut self, line: &Line<'_>, then: &mut dyn FnMut(Motion)) -> Result<(), GcodeError> {
        let mut end = self.position;
        let mut first = None;
        for (axis, (letter, end)) in AXES.into_iter().zip(&mut end).enumerate() {
            let Some(word) = line.word(letter) else { continue };
            if axis >= self.axes {
                return Err(line.at(
                    word.column,
                    Problem::NoAxis {
                        letter,
                        axes: self.axes,
                    },
                ));
            }
            first = first.or(Some(word));
            let value = word.value * self.scale;
            *end = if self.is_absolute { value } else { *end + value };
        }
        let center = OFFSETS.into_iter().chain(['R']).find_map(|letter| line.word(letter));
        match (self.motion, first, center) {
            (Some(MotionMode::Arc { is_ccw }), Some(word), _)
            | (Some(MotionMode::Arc { is_ccw }), None, Some(word)) => self.arc(line, end, is_ccw, word, then),
            (_, _, Some(center)) => Err(line.unused(center, "only arcs, G2 and G3, have centres and radii")),
            (None, Some(word), None) => Err(line.missing(
                word.column,
                "how to get there",
                "G0 or G1, G2, G3 on this line or before it",
            )),
            (Some(motion), Some(word), None) => {
                let speed = match motion {
                    MotionMode::Rapid => Speed::Rapid,
                    _ => self.speed(line, word)?,
                };
                self.straight(end, speed, then);
                Ok(())
            }
            (_, None, None) => match line.arc_without_words() {
                Some(word) => Err(line.missing(word.column, "the arc's end or centre", "X Y Z, and I J K or R")),
                None => Ok(()),
            },
        }
    }

    fn straight(&mut self, end: [f64; 3], speed: Speed, then: &mut dyn FnMut(Motion)) {
        let square: f64 = end.iter().zip(&self.position).map(|(a, b)| (a - b).powi(2)).sum();
        if square.sqrt() > NO_MOTION_MM * self.mm {
            let corner = self.corner;
            then(Motion::Line { end, speed, corner });
        }
        self.position = end;
    }

    fn arc(
        &mut self,
        line: &Line<'_>,
        end: [f64; 3],
        is_ccw: bool,
        word: &Word,
        then: &mut dyn FnMut(Motion),
    ) -> Result<(), GcodeError> {
        let speed = self.speed(line, word)?;
        let Plane([a, b, normal]) = self.plane;
        if let Some(letter) = [a, b]
            .into_iter()
            .find(|axis| *axis >= self.axes)
            .map(|axis| AXES[axis])
        {
            return Err(line.at(
                word.column,
                Problem::NoAxis {
                    letter,
                    axes: self.axes,
                },
            ));
        }
        if (end[normal] - self.position[normal]).abs() > NO_MOTION_MM * self.mm {
            let letter = AXES[normal];
            let column = line.word(letter).map_or(word.column, |word| word.column);
            return Err(line.at(column, Problem::Helix { letter }));
        }
        if let Some(word) = line.word(OFFSETS[normal]) {
            return Err(line.unused(word, "the centre is in the plane of G17, G18 or G19"));
        }
        let from = [self.position[a], self.position[b]];
        let to = [end[a], end[b]];
        let offsets = [a, b].map(|axis| line.word(OFFSETS[axis]));
        let arc = match (line.word('R'), offsets) {
            (Some(r), [Some(other), _] | [_, Some(other)]) => return Err(line.exclude(r, other)),
            (Some(r), [None, None]) => Arc::with_radius(from, to, r.value * self.scale, is_ccw, self.mm),
            (None, [None, None]) => {
                return Err(line.missing(word.column, "the arc's centre", "I J K in its plane, or R"));
            }
            (None, offsets) => {
                let mut center = from;
                for (center, offset) in center.iter_mut().zip(offsets) {
                    match (offset, self.is_center_absolute) {
                        (Some(offset), true) => *center = offset.value * self.scale,
                        (Some(offset), false) => *center += offset.value * self.scale,
                        (None, true) => {
                            return Err(line.missing(word.column, "half of the arc's centre", "both with G90.1"));
                        }
                        (None, false) => {}
                    }
                }
                Arc::about(from, to, center, is_ccw, self.mm)
            }
        };
        let arc = arc.map_err(|problem| line.at(word.column, problem))?;
        if arc.length() < STRAIGHT_ARC_MM * self.mm {
            self.straight(end, speed, then);
            return Ok(());
        }
        let at = |flat: [f64; 2]| {
            let mut point = end;
            point[a] = flat[0];
            point[b] = flat[1];
            point
        };
        let mut parts = arc.parts().peekable();
        while let Some((via, end)) = parts.next() {
            // Inside the arc there is no corner.
            let corner = if parts.peek().is_some() {
                Corner::Exact
            } else {
                self.corner
            };
            let (via, end) = (at(via), at(end));
            then(Motion::Arc {
                via,
                end,
                speed,
                corner,
            });
        }
        self.position = end;
        Ok(())
    }

    fn speed(&self, line: &Line<'_>, word: &Word) -> Result<Speed, GcodeError> {
        match self.feed {
            Some(feed) if feed > 0.0 => Ok(Speed::Feed(feed)),
            _ => Err(line.missing(
                word.column,
                "the feed rate",
                "F, more than 0, on this line or before it",
            )),
        }
    }
}

/// The words of a line, checked against each other.
struct Line<'w> {
    number: usize,
    meanings: Vec<(Meaning, &'w Word)>,
    words: Vec<&'w Word>,
    is_end: bool,
}

impl<'w> Line<'w> {
    fn new(words: &'w [Word], number: usize, skip: &[String]) -> Result<Self, GcodeError> {
        let is_skipped = |word: &Word| {
            let (name, letter) = (word.name(), word.letter.to_string());
            skip.iter().any(|skipped| *skipped == name || *skipped == letter)
        };
        let mut line = Self {
            number,
            meanings: Vec::new(),
            words: Vec::new(),
            is_end: false,
        };
        let mut groups: Vec<(u8, &Word)> = Vec::new();
        for word in words {
            match word.letter {
                'G' => {
                    let found = G_WORDS
                        .iter()
                        .find(|(tenths, ..)| word.value == f64::from(*tenths) / 10.0);
                    if found.is_none() && is_skipped(word) {
                        continue;
                    }
                    let (_, group, meaning) = found.ok_or_else(|| line.unknown(word))?;
                    if let Some((_, other)) = groups.iter().find(|(other, _)| other == group) {
                        return Err(line.at(word.column, exclude(other, word)));
                    }
                    groups.push((*group, word));
                    line.meanings.push((*meaning, word));
                }
                'M' if M_WORDS.iter().any(|known| word.value == f64::from(*known)) => line.is_end = true,
                'X' | 'Y' | 'Z' | 'I' | 'J' | 'K' | 'R' | 'F' | 'P' => {
                    if line.word(word.letter).is_some() {
                        return Err(line.at(word.column, Problem::Twice { letter: word.letter }));
                    }
                    line.words.push(word);
                }
                _ if is_skipped(word) => {}
                _ => return Err(line.unknown(word)),
            }
        }
        Ok(line)
    }

    fn word(&self, letter: char) -> Option<&'w Word> {
        self.words.iter().find(|word| word.letter == letter).copied()
    }

    /// G2 or G3 that stands here although nothing says where to.
    fn arc_without_words(&self) -> Option<&'w Word> {
        let is_arc = |meaning: &Meaning| matches!(meaning, Meaning::Motion(Some(MotionMode::Arc { .. })));
        self.meanings
            .iter()
            .find(|(meaning, _)| is_arc(meaning))
            .map(|(_, word)| *word)
    }

    fn at(&self, column: usize, problem: Problem) -> GcodeError {
        GcodeError {
            line: self.number,
            column,
            problem,
        }
    }

    fn unknown(&self, word: &Word) -> GcodeError {
        self.at(word.column, Problem::Unknown { word: word.name() })
    }

    fn value(&self, word: &Word, expected: &'static str) -> GcodeError {
        let (letter, value) = (word.letter, word.value);
        let problem = Problem::Value {
            letter,
            value,
            expected,
        };
        self.at(word.column, problem)
    }

    fn unused(&self, word: &Word, expected: &'static str) -> GcodeError {
        let letter = word.letter;
        self.at(word.column, Problem::Unused { letter, expected })
    }

    fn missing(&self, column: usize, what: &'static str, expected: &'static str) -> GcodeError {
        self.at(column, Problem::Missing { what, expected })
    }

    fn exclude(&self, first: &Word, second: &Word) -> GcodeError {
        self.at(second.column, exclude(first, second))
    }
}

fn exclude(first: &Word, second: &Word) -> Problem {
    Problem::Exclude {
        first: first.name(),
        second: second.name(),
    }
}
