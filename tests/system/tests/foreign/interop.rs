//! Unmodified clients of others: browsing, every type and shape of tag, moves, refusals. The scripts and
//! the program in `tests/python`, `tests/node` and `tests/libplctag` have the expectations.

use arcline_system_tests::interop::{
    libplctag, libplctag_hangs, libplctag_through, node, node_through, python, python_hangs, python_io,
    python_on_program, python_on_the_step_clock, python_through,
};
use arcline_system_tests::tunnel::Kind;

#[test]
fn cm_ethernetip_works_unmodified() {
    python("cm_ethernetip", "cm_ethernetip_all.py");
}

#[test]
fn the_scanner_of_cm_ethernetip_works_unmodified() {
    python_io("cm_ethernetip", "cm_ethernetip_io.py");
}

#[test]
fn cpppo_works_unmodified() {
    python("cpppo", "cpppo_all.py");
}

#[test]
fn ethernet_ip_works_unmodified() {
    node("ethernet_ip.js");
}

#[test]
fn the_scanner_of_ethernetip_works_unmodified() {
    python_io("ethernetip", "ethernetip_io.py");
}

#[test]
fn libplctag_works_unmodified() {
    libplctag();
}

#[test]
fn pycomm3_works_unmodified() {
    python("pycomm3", "pycomm3_move.py");
}

#[test]
fn pycomm3_steps_the_clock_to_the_same_positions_every_time() {
    python_on_the_step_clock("pycomm3", "pycomm3_clock.py");
}

#[test]
fn pycomm3_reads_and_writes_every_type_and_shape() {
    python("pycomm3", "pycomm3_tags.py");
}

#[test]
fn pycomm3_reads_and_writes_the_tags_of_a_program_that_runs() {
    python_on_program("pycomm3", "pycomm3_program.py");
}

#[test]
fn a_jog_of_pycomm3_that_hangs_stops() {
    python_hangs("pycomm3", "pycomm3_jog.py");
}

#[test]
fn a_jog_of_pylogix_that_hangs_stops() {
    python_hangs("pylogix", "pylogix_jog.py");
}

#[test]
fn a_jog_of_libplctag_that_hangs_stops() {
    libplctag_hangs();
}

#[test]
fn pylogix_works_unmodified() {
    python("pylogix", "pylogix_move.py");
}

#[test]
fn pylogix_reads_and_writes_every_type_and_shape() {
    python("pylogix", "pylogix_tags.py");
}

#[test]
fn st_ethernet_ip_works_unmodified() {
    node("st_ethernet_ip.js");
}

#[test]
fn pycomm3_reads_and_writes_through_stunnel() {
    python_through(Kind::Stunnel, "pycomm3", "pycomm3_tags.py");
}

#[test]
fn pylogix_reads_and_writes_through_stunnel() {
    python_through(Kind::Stunnel, "pylogix", "pylogix_tags.py");
}

#[test]
fn pycomm3_reads_and_writes_through_socat() {
    python_through(Kind::Socat, "pycomm3", "pycomm3_tags.py");
}

#[test]
fn pylogix_moves_through_socat() {
    python_through(Kind::Socat, "pylogix", "pylogix_move.py");
}

#[test]
fn cpppo_works_through_stunnel() {
    python_through(Kind::Stunnel, "cpppo", "cpppo_all.py");
}

#[test]
fn cm_ethernetip_works_through_socat() {
    python_through(Kind::Socat, "cm_ethernetip", "cm_ethernetip_all.py");
}

#[test]
fn libplctag_works_through_stunnel() {
    libplctag_through(Kind::Stunnel);
}

#[test]
fn st_ethernet_ip_works_through_socat() {
    node_through(Kind::Socat, "st_ethernet_ip.js");
}

#[test]
fn ethernet_ip_works_through_stunnel() {
    node_through(Kind::Stunnel, "ethernet_ip.js");
}
