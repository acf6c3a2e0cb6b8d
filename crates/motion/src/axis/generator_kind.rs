//! The kinds of generators of an axis: which instructions begin them, and what ends them.

/// The kinds of motion of an axis: one generator of each kind at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GeneratorKind {
    /// A coordinated move, or the axis's part of one that was ended and brakes.
    System,
    /// A stop of everything on the axis.
    Stop,
    /// MAM.
    Move,
    /// MAJ.
    Jog,
    /// MAH.
    Home,
    /// MAG.
    Gear,
    /// MAPC.
    PositionCam,
    /// MATC.
    TimeCam,
    /// MCT: the axis follows another coordinate system, or is led back by it.
    Transform,
    /// The stop of an axis whose transform was cancelled.
    Parting,
    /// MAM of a master offset: it moves the master of the position cam, as that sees it, and the axis only through that. Its
    /// frame is the offset, master units.
    MasterOffset,
}

impl GeneratorKind {
    pub(crate) const ALL: [GeneratorKind; GENERATOR_KINDS] = [
        GeneratorKind::System,
        GeneratorKind::Stop,
        GeneratorKind::Move,
        GeneratorKind::Jog,
        GeneratorKind::Home,
        GeneratorKind::Gear,
        GeneratorKind::PositionCam,
        GeneratorKind::TimeCam,
        GeneratorKind::Transform,
        GeneratorKind::Parting,
        GeneratorKind::MasterOffset,
    ];

    /// Those that can be a function of a master's displacement by themselves.
    pub(crate) const GUIDED: [GeneratorKind; 3] =
        [GeneratorKind::Move, GeneratorKind::Jog, GeneratorKind::MasterOffset];

    /// Whether a single-axis instruction begins it: what merges and stops of the axis end.
    pub(crate) fn is_single_axis(self) -> bool {
        matches!(
            self,
            GeneratorKind::Move
                | GeneratorKind::Jog
                | GeneratorKind::Home
                | GeneratorKind::Gear
                | GeneratorKind::PositionCam
                | GeneratorKind::TimeCam
        )
    }

    /// Whether it moves the axis by itself: neither a coordinate system nor a transform gives it.
    pub(crate) fn is_own(self) -> bool {
        !matches!(self, GeneratorKind::System) && !self.is_of_transforms()
    }

    /// Whether a transform moves the axis by it, or what is left of one.
    pub(crate) fn is_of_transforms(self) -> bool {
        matches!(self, GeneratorKind::Transform | GeneratorKind::Parting)
    }

    /// Its name in messages.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            GeneratorKind::System => "coordinated motion",
            GeneratorKind::Stop => "a stop",
            GeneratorKind::Move => "MAM",
            GeneratorKind::Jog => "MAJ",
            GeneratorKind::Home => "MAH",
            GeneratorKind::Gear => "MAG",
            GeneratorKind::PositionCam => "MAPC",
            GeneratorKind::TimeCam => "MATC",
            GeneratorKind::Transform => "a transform",
            GeneratorKind::Parting => "the stop of a cancelled transform",
            GeneratorKind::MasterOffset => "a master offset",
        }
    }

    pub(super) const fn bit(self) -> u16 {
        1 << self as u8
    }
}

pub(super) const GENERATOR_KINDS: usize = 11;

/// Displacements of an axis by kind of generator, position units.
pub(super) type Displacements = [f64; GENERATOR_KINDS];

/// The kinds of generators whose bits are set.
pub(super) fn kinds(mut bits: u16) -> impl Iterator<Item = GeneratorKind> {
    std::iter::from_fn(move || {
        let kind = *GeneratorKind::ALL.get(bits.trailing_zeros() as usize)?;
        bits &= bits - 1;
        Some(kind)
    })
}
