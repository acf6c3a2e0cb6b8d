//! The HMI in a real browser, against a real server. The scripts in `tests/browser` say what is expected.

use arcline_tests::browser::{case, case_on};

macro_rules! cases {
    ($($name:ident),* $(,)?) => {
        $(#[test]
        fn $name() {
            case(stringify!($name));
        })*
    };
}

cases! {
    a_path_is_drawn,
    a_move_started_by_the_form_arrives,
    an_error_is_explained,
    a_jog_ends_with_its_page,
    esc_stops,
    the_picture_turns_and_scales,
    the_scrub_shows_an_earlier_moment,
    a_new_page_has_the_past,
    the_history_is_exact,
    the_target_dialog_is_the_users,
    every_instruction_has_a_form,
    a_program_runs,
    a_finger_jogs_while_it_is_down,
    the_keyboard_drives,
    a_stray_click_moves_nothing,
    a_lost_server_is_told,
    tags_are_watched_and_written,
    screenshots,
}

#[test]
fn frames_leave_time() {
    case_on("frames_leave_time", "eight.toml");
}

#[test]
fn a_robots_tool_is_drawn() {
    case_on("a_robots_tool_is_drawn", "../../docs/images/tool-path.toml");
}
