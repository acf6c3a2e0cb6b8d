use arcline_profile::*;
fn main() {
    let l = Limits {
        speed: 200.0,
        acceleration: 2000.0,
        deceleration: 1000.0,
        jerk: Some(Jerk {
            acceleration: 20000.0,
            deceleration: 5000.0,
        }),
    };
    let p = Profile::stop(
        State {
            position: 40.0,
            velocity: 200.0,
            acceleration: 0.0,
        },
        &l,
    );
    println!("{:?} {} {:?}", p.end(), p.duration(), p.segment_times());
    println!("{}", jerk_from_percent_of_time(200.0, 1000.0, 100.0));
    let p = Profile::to_position(
        State {
            position: 0.0,
            velocity: 0.0,
            acceleration: 0.0,
        },
        100.0,
        0.0,
        &Limits {
            speed: 200.0,
            acceleration: 2000.0,
            deceleration: 2000.0,
            jerk: Some(Jerk {
                acceleration: 20000.0,
                deceleration: 20000.0,
            }),
        },
    );
    println!("{:?} {:?}", p.at(0.3), p.segment_times());
}
