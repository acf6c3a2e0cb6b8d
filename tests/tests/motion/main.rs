//! The effects of instructions, one program of tests for all of them: each module is a family of instructions or a property of the
//! machine, on the virtual clock.

mod axes;
mod blends;
mod cams;
mod contour_stops;
mod contours;
mod coordinated_stops;
mod error_codes;
mod faults;
mod feed_override;
mod fieldbus;
mod gears;
mod group;
mod home;
mod masters;
mod moves;
mod outputs;
mod path_speed;
mod probes;
mod robots;
mod semantics;
mod settings;
mod simulated_drive;
mod splices;
mod state_matrix;
mod status_bits;
mod stop_table;
mod streams;
mod toolpaths;
mod transforms;
mod update_periods;
mod wild;
