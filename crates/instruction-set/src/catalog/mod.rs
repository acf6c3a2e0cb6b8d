//! The faceplates: the only place where the operands of an instruction are listed.
//!
//! Operands stand in faceplate order; the place of one, counted from 0, is also the EXERR of "Parameter Out
//! Of Range" (13). Sources: spec/coordinated-instructions.md §12–§25, spec/axis-and-data-types.md §2–§4.

#[macro_use]
mod row;
mod axis;
mod bits;
mod coordinated;
mod group;
mod groups;
mod resolve;

use crate::Mnemonic;

pub use typed::*;

/// Every faceplate with the struct of its operands.
pub(crate) mod typed {
    pub use super::axis::*;
    pub use super::coordinated::*;
    pub use super::group::*;
    pub use super::groups::*;
}

/// Class 0x0300 in the order of the service codes.
pub const MOTION_GROUP: &[Mnemonic] = &[
    Mnemonic::Mgs,
    Mnemonic::Mgsd,
    Mnemonic::Mgsr,
    Mnemonic::Mgsp,
    Mnemonic::Mccp,
    Mnemonic::Mcsv,
];

/// Class 0x0301 in the order of the service codes.
pub const AXIS: &[Mnemonic] = &[
    Mnemonic::Mso,
    Mnemonic::Msf,
    Mnemonic::Masd,
    Mnemonic::Masr,
    Mnemonic::Mafr,
    Mnemonic::Mas,
    Mnemonic::Mah,
    Mnemonic::Maj,
    Mnemonic::Mam,
    Mnemonic::Mag,
    Mnemonic::Mcd,
    Mnemonic::Mrp,
    Mnemonic::Mdac,
    Mnemonic::Mapc,
    Mnemonic::Matc,
    Mnemonic::Maw,
    Mnemonic::Mdw,
    Mnemonic::Mar,
    Mnemonic::Mdr,
    Mnemonic::Maoc,
    Mnemonic::Mdoc,
];

/// Class 0x0302 in the order of the service codes.
pub const COORDINATE_SYSTEM: &[Mnemonic] = &[
    Mnemonic::Mclm,
    Mnemonic::Mccm,
    Mnemonic::Mccd,
    Mnemonic::Mcs,
    Mnemonic::Mcsd,
    Mnemonic::Mcsr,
    Mnemonic::Mdcc,
    Mnemonic::Mct,
    Mnemonic::Mctp,
    Mnemonic::Mcpm,
    Mnemonic::Mcto,
    Mnemonic::Mctpo,
];

#[cfg(test)]
mod tests {
    use crate::{Kind, MAX_OPERANDS, Mnemonic, Object, by_service, services};

    #[test]
    fn services_are_those_of_the_contract() {
        #[rustfmt::skip]
        let cases = [
            (0x0302, 0x32, "MCLM"), (0x0302, 0x33, "MCCM"), (0x0302, 0x34, "MCCD"), (0x0302, 0x35, "MCS"),
            (0x0302, 0x3D, "MCTPO"), (0x0301, 0x32, "MSO"), (0x0301, 0x33, "MSF"), (0x0301, 0x40, "MATC"),
            (0x0300, 0x35, "MGSP"), (0x0300, 0x37, "MCSV"), (0x0301, 0x41, "MAW"), (0x0301, 0x46, "MDOC"),
        ];
        for (class, service, name) in cases {
            let mnemonic: Mnemonic = name.parse().expect(name);
            assert_eq!(by_service(class, service), Some(mnemonic), "{name}");
            assert_eq!(mnemonic.instruction().service(), (class, service), "{name}");
        }
        for (class, service) in [
            (0x0302, 0x31),
            (0x0302, 0x3E),
            (0x0303, 0x32),
            (0x0301, 0x47),
            (0x0300, 0x38),
        ] {
            assert_eq!(by_service(class, service), None, "{class:#06x} {service:#04x}");
        }
    }

    #[test]
    fn the_catalogue_is_whole() {
        let all: usize = Object::ALL.into_iter().map(|object| services(object).len()).sum();
        assert_eq!(all, Mnemonic::ALL.len());
        for mnemonic in Mnemonic::ALL {
            let instruction = mnemonic.instruction();
            assert_eq!(instruction.mnemonic, *mnemonic);
            assert!(instruction.operands.len() <= MAX_OPERANDS, "{mnemonic}");
            let kinds = instruction.operands.iter().map(|operand| &operand.kind);
            let target = |kind: &Kind| matches!(kind, Kind::Target(object) if *object == instruction.object);
            let is_first = target(&instruction.operands[0].kind);
            assert_eq!(is_first, instruction.has_target(), "{mnemonic}");
            let calculates = matches!(mnemonic, Mnemonic::Mccp | Mnemonic::Mcsv);
            assert_eq!(is_first, !calculates, "{mnemonic}");
            assert_eq!(
                kinds.filter(|kind| matches!(kind, Kind::MotionControl)).count(),
                1,
                "{mnemonic}"
            );
            for (k, operand) in instruction.operands.iter().enumerate() {
                assert_eq!(
                    instruction.operand(operand.name),
                    Some(k),
                    "{mnemonic} {}",
                    operand.name
                );
                assert_eq!(
                    instruction.operand(&operand.member()),
                    Some(k),
                    "{mnemonic} {}",
                    operand.name
                );
            }
        }
    }

    #[test]
    fn operands_stand_at_the_positions_of_the_specification() {
        #[rustfmt::skip]
        let cases: &[(&str, &[(usize, &str)])] = &[
            ("MCLM", &[(2, "MoveType"), (3, "Position"), (4, "Speed"), (5, "SpeedUnits"), (6, "AccelRate"),
                (8, "DecelRate"), (10, "Profile"), (11, "AccelJerk"), (12, "DecelJerk"), (13, "JerkUnits"),
                (14, "TerminationType"), (15, "Merge"), (16, "MergeSpeed"), (17, "CommandTolerance"),
                (18, "LockPosition"), (19, "LockDirection"), (20, "EventDistance"), (21, "CalculatedData")]),
            ("MCCM", &[(4, "CircleType"), (5, "ViaCenterRadius"), (6, "Direction"), (7, "Speed"), (9, "AccelRate"),
                (11, "DecelRate"), (13, "Profile"), (14, "AccelJerk"), (16, "JerkUnits"), (17, "TerminationType"),
                (20, "CommandTolerance"), (22, "LockDirection"), (24, "CalculatedData")]),
            ("MCCD", &[(2, "MotionType"), (4, "Speed"), (7, "AccelRate"), (10, "DecelRate"), (13, "AccelJerk"),
                (15, "DecelJerk"), (16, "JerkUnits"), (17, "Scope")]),
            ("MCS", &[(2, "StopType"), (3, "ChangeDecel"), (4, "DecelRate"), (7, "DecelJerk"), (8, "JerkUnits")]),
            ("MAM", &[(4, "Speed"), (6, "AccelRate"), (8, "DecelRate"), (17, "LockDirection"), (19, "CalculatedData")]),
            ("MAJ", &[(2, "Direction"), (3, "Speed"), (12, "JerkUnits"), (16, "LockDirection")]),
            ("MAG", &[(1, "MasterAxis"), (2, "MotionControl"), (3, "Direction"), (9, "Clutch"), (11, "AccelUnits")]),
            ("MCD", &[(4, "Speed"), (12, "DecelJerk"), (13, "SpeedUnits"), (16, "JerkUnits")]),
            ("MAPC", &[(4, "CamProfile"), (12, "MasterDirection")]),
            ("MATC", &[(3, "CamProfile"), (10, "InstructionMode")]),
            ("MDCC", &[(1, "MasterAxis"), (3, "MasterReference"), (4, "NominalMasterVelocity")]),
            ("MCTPO", &[(5, "TransformDirection"), (9, "TurnsCounter")]),
        ];
        for (name, operands) in cases {
            let instruction = name.parse::<Mnemonic>().expect(name).instruction();
            for (place, member) in *operands {
                assert_eq!(instruction.operands[*place].member(), *member, "{name} {place}");
            }
        }
    }
}
