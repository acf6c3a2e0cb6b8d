//! The kinds of generators of an axis: the instructions that begin and end them.

/// The kinds of motion of an axis: one generator of each kind at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum GeneratorKind {
    /// A coordinated move, or the axis's part of an ended one that still brakes.
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
    /// MCT: the axis follows another coordinate system, or follows it through the feedback of the transform.
    Transform,
    /// The stop of an axis after the cancellation of its transform.
    TransformStop,
    /// MAM of a master offset: it shifts the master position that the position cam reads, and moves the axis only through the cam. Its
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
        GeneratorKind::TransformStop,
        GeneratorKind::MasterOffset,
    ];

    /// The kinds whose profile can be a function of a master's displacement.
    pub(crate) const MASTER_DRIVEN: [GeneratorKind; 3] =
        [GeneratorKind::Move, GeneratorKind::Jog, GeneratorKind::MasterOffset];

    /// A single-axis instruction begins it; merges and stops of the axis end it.
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

    /// It moves the axis on its own, not as part of a coordinate system or a transform.
    pub(crate) fn is_own(self) -> bool {
        !matches!(self, GeneratorKind::System) && !self.is_of_transforms()
    }

    /// It is the motion of a transform, or the motion that a cancelled transform left.
    pub(crate) fn is_of_transforms(self) -> bool {
        matches!(self, GeneratorKind::Transform | GeneratorKind::TransformStop)
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
            GeneratorKind::TransformStop => "the stop of a cancelled transform",
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
