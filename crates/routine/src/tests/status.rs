//! Status bits, and the minor faults of arithmetic (spec/programs.md §7).

use super::{project, script};

#[test]
fn a_division_by_0_is_one_minor_fault() {
    #[rustfmt::skip]
    let cases = [
        ("DIV(A,Z,D);",         ":Count=1;D=7;V=1"),
        ("DIV(A,Z,R);",         ":Count=1;V=1"),
        ("DIV(R,Z,D);",         ":Count=1"),
        ("MOD(A,Z,D);",         ":Count=1;D=0;V=1"),
        ("MOD(A,Z,R);",         ":Count=1;R=0;V=1"),
        ("CPT(D,A / Z);",       ":Count=1;D=7"),
        ("CPT(R,A / Z);",       ":Count=1"),
        ("CPT(D,A / Z + 1);",   ":Count=1;D=8"),
        ("TOD(N,D);",           ":Count=1"),
        ("ADD(M,M,D);",         ":Count=1"),
        ("DIV(A,Z,D)ADD(M,M,D);", ":Count=2"),
        ("ADD(A,A,D);",         ":Count=0;V=0"),
        ("CMP(A / Z > 1);",     ":Count=1"),
    ];
    for (rung, lines) in cases {
        let rungs = format!("{rung}\nXIC(S:V)OTE(V);\nGSV(FaultLog,,MinorEvents,Count);");
        let of = project(
            "A DINT 7, Z DINT, D DINT, R REAL, N DINT -1, M DINT 2147483647, V BOOL, Count DINT",
            &[("Main", &rungs)],
        );
        script(rung, &of, lines);
    }
    let of = project(
        "A DINT 7, Z DINT, D DINT, Count DINT",
        &[(
            "Main",
            "ST\nD := A / Z;\nD := A MOD Z;\nGSV(FaultLog,,MinorEvents,Count);",
        )],
    );
    script("Structured Text", &of, ":Count=2;D=0");
}
