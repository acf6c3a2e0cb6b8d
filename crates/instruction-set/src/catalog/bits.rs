//! The status bits that an instruction uses.

use crate::Flag;

pub(super) const EN_DN_ER: &[Flag] = &[Flag::En, Flag::Dn, Flag::Er];
pub(super) const EN_DN_ER_IP: &[Flag] = &[Flag::En, Flag::Dn, Flag::Er, Flag::Ip];
pub(super) const EN_DN_ER_IP_AC: &[Flag] = &[Flag::En, Flag::Dn, Flag::Er, Flag::Ip, Flag::Ac];
pub(super) const EN_DN_ER_IP_PC: &[Flag] = &[Flag::En, Flag::Dn, Flag::Er, Flag::Ip, Flag::Pc];
pub(super) const JOG_BITS: &[Flag] = &[
    Flag::En,
    Flag::Dn,
    Flag::Er,
    Flag::Ip,
    Flag::Ac,
    Flag::Accel,
    Flag::Decel,
    Flag::TrackingMaster,
];
pub(super) const PATH_BITS: &[Flag] = &[
    Flag::En,
    Flag::Dn,
    Flag::Er,
    Flag::Ip,
    Flag::Ac,
    Flag::Pc,
    Flag::Accel,
    Flag::Decel,
    Flag::TrackingMaster,
];

pub(super) const PATH_BITS_CALCULATED: &[Flag] = &[
    Flag::En,
    Flag::Dn,
    Flag::Er,
    Flag::Ip,
    Flag::Ac,
    Flag::Pc,
    Flag::Accel,
    Flag::Decel,
    Flag::TrackingMaster,
    Flag::CalculatedDataAvailable,
];
