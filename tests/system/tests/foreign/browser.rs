//! The HMI in a real browser, against a real server. The scripts in `tests/browser` have the expectations.

use arcline_system_tests::browser::{case, case_among_strangers, case_on, case_with_missing_parts, case_with_users};

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
    a_press_behind_an_edit_runs_the_edit,
    an_error_is_explained,
    a_fault_is_an_event,
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

macro_rules! cases_of_a_cell {
    ($($name:ident),* $(,)?) => {
        $(#[test]
        fn $name() {
            case_on(stringify!($name), "cell.toml");
        })*
    };
}

cases_of_a_cell! {
    a_live_view_says_so,
    a_reload_shows_no_error,
    a_value_that_does_not_fit_is_refused,
    an_axis_has_its_own_form,
    an_error_is_one_message,
    an_error_of_a_program_goes,
    axe_finds_nothing,
    colours_are_told_apart,
    control_is_offered_where_it_is_missing,
    control_is_taken_over,
    nothing_overflows,
    a_damaged_choice_is_left_out,
    a_move_beyond_the_travel_asks,
    targets_follow_the_machine,
    the_numbers_of_a_grid_are_apart,
}

#[test]
fn a_robots_tool_is_drawn() {
    case_on("a_robots_tool_is_drawn", "../../docs/images/tool-path.toml");
}

#[test]
fn a_machine_without_axes_has_a_page() {
    case_on("a_machine_without_axes_has_a_page", "empty.toml");
}

#[test]
fn a_login_gives_the_role() {
    case_with_users("a_login_gives_the_role", false);
}

#[test]
fn a_login_over_https_gives_the_role() {
    case_with_users("a_login_gives_the_role", true);
}

#[test]
fn an_administrator_ends_a_session() {
    case_with_users("an_administrator_ends_a_session", true);
}

#[test]
fn a_users_name_is_text() {
    case_with_users("a_users_name_is_text", true);
}

#[test]
fn a_program_is_seen() {
    case_on("a_program_is_seen", "ladder.toml");
}

#[test]
fn parts_that_do_not_run_are_named_at_their_rungs() {
    case_with_missing_parts("parts_that_do_not_run_are_named_at_their_rungs");
}

#[test]
fn a_fault_leads_to_its_rung() {
    case_on("a_fault_leads_to_its_rung", "ladder.toml");
}

#[test]
fn a_program_fits_small_screens() {
    case_on("a_program_fits_small_screens", "ladder.toml");
}

#[test]
fn names_and_values_are_text() {
    case_on("names_and_values_are_text", "markup.toml");
}

#[test]
fn texts_of_strangers_are_shown_as_text() {
    case_among_strangers("texts_of_strangers_are_shown_as_text");
}
