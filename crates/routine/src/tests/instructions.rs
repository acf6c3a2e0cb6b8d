//! Each instruction: prescan, false and true rungs, edges, overflow, types (spec/programs.md §10).

use super::{NoMachine, project, script};
use crate::load;

/// Name, tags, rungs, script.
type Row = (&'static str, &'static str, &'static str, &'static str);

/// The same with several routines by name.
type Routines = (
    &'static str,
    &'static str,
    &'static [(&'static str, &'static str)],
    &'static str,
);

fn run(rows: &[Row]) {
    for (why, tags, rungs, lines) in rows {
        script(why, &project(tags, &[("Main", rungs)]), lines);
    }
}

#[test]
fn bits() {
    #[rustfmt::skip]
    let rows: &[Row] = &[
        ("XIC and XIO", "I BOOL, A BOOL, B BOOL", "XIC(I)OTE(A);\nXIO(I)OTE(B);", ":A=0;B=1\nI:A=1;B=0\nI=0:A=0;B=1"),
        ("XIC of a calculated bit", "W DINT 5, N DINT, A BOOL", "XIC(W.[N])OTE(A);", ":A=1\nN=1:A=0\nN=2:A=1"),
        ("a bit of an array of BOOLs", "B BOOL[40], N DINT, A BOOL", "XIC(B[N])OTE(A);\nOTE(B[37]);", ":A=0;B[37]=1\nN=37:A=1"),
        ("OTE in prescan", "A BOOL 1, B BOOL 1", "OTE(A);\nOTL(B);", "pre:A=0;B=1\n:A=1"),
        ("OTL and OTU", "S BOOL, R BOOL, A BOOL", "XIC(S)OTL(A);\nXIC(R)OTU(A);", ":A=0\nS:A=1\nS=0:A=1\nR:A=0\nR=0:A=0"),
        ("ONS", "I BOOL, S BOOL, N DINT", "XIC(I)ONS(S)ADD(N,1,N);", "pre:S=1\n:S=0\nI:N=1\n:N=1\nI=0:N=1\nI:N=2"),
        ("OSR", "I BOOL, S BOOL, O BOOL, P BOOL", "XIC(I)OSR(S,O)OTE(P);", "pre:S=1;O=0\n:S=0\nI:O=1;P=1\n:O=0;P=1\nI=0:O=0;S=0"),
        ("OSF", "I BOOL, S BOOL, O BOOL", "XIC(I)OSF(S,O);", "pre:S=0;O=0\nI:O=0;S=1\nI=0:O=1;S=0\n:O=0"),
        ("OSRI", "F FBD_ONESHOT, N DINT", "ST\nOSRI(F);\nIF F.OutputBit THEN N := N + 1; END_IF;", "F.InputBit:N=0\n:N=0\nF.InputBit=0:N=0\nF.InputBit:N=1\n:N=1"),
        ("OSFI", "F FBD_ONESHOT, N DINT", "ST\nOSFI(F);\nIF F.OutputBit THEN N := N + 1; END_IF;", "F.InputBit:N=0\nF.InputBit=0:N=1\n:N=1"),
        ("AFI and NOP", "A BOOL, B BOOL", "AFI()OTE(A);\nNOP()OTE(B);", ":A=0;B=1"),
        ("a branch inside a branch", "A BOOL, B BOOL, C BOOL, O BOOL", "[XIC(A) ,[XIC(B) ,] XIC(C) ]OTE(O);", ":O=0\nC:O=1\nC=0,A:O=1"),
        ("an alias of a bit would be a bit", "W DINT, A BOOL", "XIC(W.3)OTE(A);", "W=8:A=1\nW=7:A=0"),
    ];
    run(rows);
}

#[test]
fn timers_and_counters() {
    #[rustfmt::skip]
    let rows: &[Row] = &[
        ("TON", "I BOOL, T TIMER 30", "XIC(I)TON(T,?,?);", "pre:T.ACC=0\nI:T.EN=1;T.TT=1;T.ACC=0\n2 x:T.ACC=20;T.TT=1\n:T.ACC=30;T.DN=1;T.TT=0\n:T.ACC=30\nI=0:T.ACC=0;T.DN=0;T.EN=0"),
        ("TON, DN set by hand pauses", "I BOOL, T TIMER 100", "XIC(I)TON(T,?,?);", "I:T.ACC=0\n:T.ACC=10\nT.DN:T.ACC=10\nT.DN=0:T.ACC=20"),
        ("TOF", "I BOOL, T TIMER 20", "XIC(I)TOF(T,?,?);", "pre:T.ACC=20;T.DN=0\nI:T.EN=1;T.DN=1;T.TT=0;T.ACC=0\nI=0:T.EN=0;T.DN=1;T.TT=1;T.ACC=0\n:T.ACC=10\n:T.ACC=20;T.DN=0;T.TT=0"),
        ("RTO", "I BOOL, R BOOL, T TIMER 30", "XIC(I)RTO(T,?,?);\nXIC(R)RES(T);", "I:T.ACC=0\n2 x:T.ACC=20\nI=0:T.ACC=20;T.EN=0;T.TT=0\n3 x:T.ACC=20\nI:T.ACC=20\n:T.ACC=30;T.DN=1\nR:T.ACC=0;T.DN=0"),
        ("CTU", "I BOOL, C COUNTER 2", "XIC(I)CTU(C,?,?);", "pre:C.CU=1\n:C.CU=0\nI:C.ACC=1;C.CU=1;C.DN=0\n:C.ACC=1\nI=0:C.CU=0\nI:C.ACC=2;C.DN=1"),
        ("CTU overflows", "I BOOL, C COUNTER 2", "XIC(I)CTU(C,?,?);", ":C.ACC=0\nC.ACC=2147483647,I:C.ACC=-2147483648;C.OV=1"),
        ("CTD", "I BOOL, C COUNTER 0", "XIC(I)CTD(C,?,?);", "pre:C.CD=1\n:C.DN=1\nI:C.ACC=-1;C.DN=0;C.CD=1\n:C.ACC=-1"),
        ("CTD underflows", "I BOOL, C COUNTER 0", "XIC(I)CTD(C,?,?);", ":C.ACC=0\nC.ACC=-2147483648,I:C.ACC=2147483647;C.UN=1"),
        ("RES of a counter counts again", "R BOOL, C COUNTER 9", "CTU(C,?,?);\nXIC(R)RES(C);", ":C.ACC=0\nR:C.ACC=0;C.CU=0\n:C.ACC=0"),
        ("TONR", "F FBD_TIMER", "ST\nTONR(F);", "F.PRE=20,F.TimerEnable:F.ACC=0;F.EN=1;F.TT=1\n:F.ACC=10\n:F.ACC=20;F.DN=1;F.TT=0\nF.Reset:F.ACC=0;F.DN=0\nF.Reset=0,F.TimerEnable=0:F.EN=0"),
        ("TONR with a negative preset", "F FBD_TIMER", "ST\nTONR(F);", "F.PRE=-1,F.TimerEnable:F.Status=2;F.ACC=0"),
        ("TOFR", "F FBD_TIMER", "ST\nTOFR(F);", "F.PRE=20,F.TimerEnable:F.DN=1\nF.TimerEnable=0:F.DN=1;F.TT=1\n2 x:F.DN=0"),
        ("RTOR", "F FBD_TIMER", "ST\nRTOR(F);", "F.PRE=90,F.TimerEnable:F.ACC=0\n:F.ACC=10\nF.TimerEnable=0:F.ACC=10\n:F.ACC=10\nF.TimerEnable:F.ACC=10\n:F.ACC=20"),
        ("CTUD", "F FBD_COUNTER", "ST\nCTUD(F);", ":F.ACC=0\nF.PRE=1,F.CUEnable:F.ACC=1;F.DN=1\n:F.ACC=1\nF.CDEnable:F.ACC=0;F.DN=0\nF.CUEnable=0:F.ACC=0\nF.CUEnable:F.ACC=1\nF.Reset:F.ACC=0"),
    ];
    run(rows);
}

#[test]
fn comparisons() {
    #[rustfmt::skip]
    let rows: &[Row] = &[
        ("both spellings", "N DINT 5, A BOOL, B BOOL", "EQU(N,5)OTE(A);\nEQ(N,5)OTE(B);", ":A=1;B=1\nN=6:A=0;B=0"),
        ("NEQ NE", "N DINT 5, A BOOL, B BOOL", "NEQ(N,5)OTE(A);\nNE(N,5)OTE(B);", ":A=0;B=0\nN=6:A=1;B=1"),
        ("GRT GEQ", "N DINT 5, A BOOL, B BOOL, C BOOL, D BOOL", "GRT(N,5)OTE(A);\nGEQ(N,5)OTE(B);\nGT(N,4)OTE(C);\nGE(N,6)OTE(D);", ":A=0;B=1;C=1;D=0"),
        ("LES LEQ", "N DINT 5, A BOOL, B BOOL, C BOOL, D BOOL", "LES(N,5)OTE(A);\nLEQ(N,5)OTE(B);\nLT(N,6)OTE(C);\nLE(N,4)OTE(D);", ":A=0;B=1;C=1;D=0"),
        ("in the higher type", "N DINT 2, R REAL 2.5, A BOOL", "LES(N,R)OTE(A);", ":A=1"),
        ("LIM inside and outside", "N DINT 5, A BOOL, B BOOL", "LIM(1,N,5)OTE(A);\nLIM(5,N,1)OTE(B);", ":A=1;B=1\nN=3:A=1;B=0\nN=0:A=0;B=1"),
        ("MEQ", "N DINT 16#F5, A BOOL", "MEQ(N,16#0F,16#A5)OTE(A);", ":A=1\nN=6:A=0"),
        ("CMP", "N DINT 5, A BOOL, B BOOL", "CMP(N+1>5 AND N<>0)OTE(A);\nCMP(N)OTE(B);", ":A=1;B=1\nN=0:A=0;B=0"),
        ("texts", "S STRING ab, T STRING ac, A BOOL, B BOOL, C BOOL", "LES(S,T)OTE(A);\nEQU(S,'ab')OTE(B);\nGRT('b',T)OTE(C);", ":A=1;B=1;C=1"),
        ("not a number is different from itself", "R REAL 1.#QNAN, A BOOL, B BOOL", "EQU(R,R)OTE(A);\nNEQ(R,R)OTE(B);", ":A=0;B=1"),
    ];
    run(rows);
}

#[test]
fn arithmetic_and_moves() {
    #[rustfmt::skip]
    let rows: &[Row] = &[
        ("ADD SUB MUL", "N DINT 7, A DINT, B DINT, C DINT", "ADD(N,2,A);\nSUB(N,9,B);\nMUL(N,-3,C);", ":A=9;B=-2;C=-21"),
        ("DIV by type", "A DINT, B REAL, C DINT", "DIV(7,2,A);\nDIV(7,2,B);\nDIV(7.0,2,C);", ":A=3;B=3.5;C=4"),
        ("DIV and MOD by 0", "A DINT, B DINT, C BOOL, Z DINT", "DIV(7,Z,A);\nMOD(7,Z,B);\nXIC(S:MINOR)OTE(C);", ":A=7;B=0;C=1"),
        ("flags", "N DINT 2147483647, V BOOL, Z BOOL, M BOOL", "ADD(N,1,N);\nXIC(S:V)OTE(V);\nXIC(S:Z)OTE(Z);\nXIC(S:N)OTE(M);", ":N=-2147483648;V=1;Z=0;M=1"),
        ("zero and carry", "A DINT -1, Z BOOL, C BOOL, V BOOL", "ADD(A,1,A);\nXIC(S:Z)OTE(Z);\nXIC(S:C)OTE(C);\nXIC(S:V)OTE(V);", ":A=0;Z=1;C=1;V=0"),
        ("NEG ABS SQR", "N DINT 9, A DINT, B DINT, C DINT, D REAL", "NEG(N,A);\nABS(A,B);\nSQR(N,C);\nSQR(-2.25,D);", ":A=-9;B=9;C=3;D=1.5"),
        ("CPT and precedence", "A DINT, B REAL, C DINT", "CPT(A,2+3*4);\nCPT(B,7/2);\nCPT(C,(2+3)*4-(-1));", ":A=14;B=3.5;C=21"),
        ("functions", "A REAL, B REAL, C REAL, D DINT, E REAL", "SIN(0.0,A);\nCOS(0.0,B);\nXPY(2.0,0.5,C);\nTRN(-2.7,D);\nDEG(3.14159265,E);", ":A=0;B=1;C>1.4142;C<1.4143;D=-2;E>179.999;E<180.001"),
        ("LN LOG TAN ATN RAD", "A REAL, B REAL, C REAL, D REAL, E REAL", "LN(1.0,A);\nLOG(1000.0,B);\nTAN(0.0,C);\nATN(1.0,D);\nRAD(180.0,E);", ":A=0;B=3;C=0;D>0.78539;D<0.7854;E>3.14159;E<3.1416"),
        ("ASN outside, ACS", "A REAL, B REAL, V BOOL", "ACS(1.0,B);\nASN(2.0,A);\nXIC(S:V)OTE(V);", ":A<>A;V=1;B=0"),
        ("BCD", "A DINT, B DINT, C BOOL", "TOD(1234,A);\nFRD(16#1234,B);\nTOD(-1,A);\nXIC(S:V)OTE(C);", ":B=1234;C=1"),
        ("MOV rounds to even and keeps low bits", "A DINT, B DINT, C SINT, V BOOL", "MOV(2.5,A);\nMOV(-3.5,B);\nMOV(300,C);\nXIC(S:V)OTE(V);", ":A=2;B=-4;C=44;V=1"),
        ("MOVE of a text", "S STRING hello, T STRING", "MOVE(S,T);", ":T='hello'"),
        ("MVM and BTD", "A DINT 16#FF, B DINT 16#12345678, C DINT", "MVM(A,16#F0,B);\nBTD(16#ABCD,4,C,8,8);", ":B=16#123456F8;C=16#BC00"),
        ("BTD beyond the end", "C DINT", "BTD(16#FF,0,C,28,8);", ":C=-268435456"),
        ("AND OR XOR NOT", "A DINT, B DINT, C DINT, D DINT, S SINT -1", "AND(12,10,A);\nOR(12,10,B);\nXOR(12,10,C);\nNOT(0,D);\nOR(S,0,A);", ":A=255;B=14;C=6;D=-1"),
        ("CLR", "A DINT 5, R REAL 2.5", "CLR(A);\nCLR(R);", ":A=0;R=0"),
        ("SWPB", "A INT 16#1234, B INT, C DINT, D DINT, E DINT", "SWPB(A,REVERSE,B);\nSWPB(16#12345678,REVERSE,C);\nSWPB(16#12345678,WORD,D);\nSWPB(16#12345678,HIGH/LOW,E);", ":B=16#3412;C=16#78563412;D=16#56781234;E=16#34127856"),
        ("COP by bytes", "R REAL 1.0, N DINT, A SINT[8], B DINT[2]", "COP(R,N,1);\nCOP(16#04030201,A[1],4);\nCOP(A[0],B[0],2);", ":N=16#3F800000;A[0]=0;A[1]=1;A[4]=4;B[0]=16#03020100"),
        ("COP ends at the end", "A DINT[4] 1;2;3;4, B DINT[2], C DINT 9", "COP(A[0],B[1],9);", ":B[0]=0;B[1]=1;C=9"),
        ("FLL", "A INT[4], N DINT 7", "FLL(N,A[1],2);", ":A[0]=0;A[1]=7;A[2]=7;A[3]=0"),
        ("SIZE", "A DINT[3;5], S STRING, N DINT, M DINT, L DINT", "SIZE(A,0,N);\nSIZE(A,1,M);\nSIZE(S,0,L);", ":N=3;M=5;L=82"),
        ("several dimensions", "A DINT[3;5], I DINT 2", "MOV(7,A[I,4]);\nMOV(8,A[1,I]);", ":A[2,4]=7;A[1,2]=8"),
        ("BTDT and MVMT", "B FBD_BIT_FIELD_DISTRIBUTE, M FBD_MASKED_MOVE", "ST\nBTDT(B); MVMT(M);", "B.Source=3,B.Length=2,B.DestBit=4,B.Target=1,M.Source=15,M.Mask=3,M.Target=8:B.Dest=49;M.Dest=11"),
    ];
    run(rows);
}

#[test]
fn files_shifts_and_queues() {
    #[rustfmt::skip]
    let rows: &[Row] = &[
        ("FAL all", "I BOOL, C CONTROL 3, A DINT[3] 1;2;3, B DINT[3]", "XIC(I)FAL(C,?,?,ALL,B[C.POS],A[C.POS]*2);", ":C.DN=0\nI:B[0]=2;B[2]=6;C.DN=1;C.POS=3\n:C.DN=1\nI=0:C.EN=0"),
        ("FAL incremental", "I BOOL, C CONTROL 2, B DINT[2]", "XIC(I)FAL(C,?,?,INC,B[C.POS],5);", "I:B[0]=5;B[1]=0;C.POS=1\n:C.POS=1\nI=0:C.EN=0\nI:B[1]=5;C.DN=1"),
        ("FAL some each scan", "I BOOL, C CONTROL 5, B DINT[5]", "XIC(I)FAL(C,?,?,2,B[C.POS],1);", "I:B[1]=1;B[2]=0\nI=0:B[3]=1;B[4]=0\n:B[4]=1;C.DN=1"),
        ("FSC", "I BOOL, C CONTROL 4, A DINT[4] 5;6;7;8", "XIC(I)FSC(C,?,?,ALL,A[C.POS]>6);", "I:C.FD=1;C.IN=1;C.POS=2;C.DN=0"),
        ("AVE STD", "I BOOL, C CONTROL 4, D CONTROL 4, A REAL[4] 1;2;3;4, M REAL, S REAL", "XIC(I)AVE(A[0],0,M,C,?,?);\nXIC(I)STD(A[0],0,S,D,?,?);", "I:M=2.5;S>1.2909;S<1.291;C.DN=1"),
        ("SRT", "I BOOL, C CONTROL 5, A DINT[5] 5;-1;4;4;0", "XIC(I)SRT(A[0],0,C,?,?);", "I:A[0]=-1;A[1]=0;A[2]=4;A[3]=4;A[4]=5;C.DN=1\nI=0:C.DN=0"),
        ("BSL", "I BOOL, B BOOL 1, C CONTROL 33, A DINT[2] -2147483648;0", "XIC(I)BSL(A[0],C,B,?);", "I:A[0]=1;A[1]=1;C.UL=0;C.DN=1;C.POS=33\n:A[0]=1\nI=0:C.POS=0;C.DN=0"),
        ("BSR", "I BOOL, B BOOL 1, C CONTROL 4, A DINT[1] 3", "XIC(I)BSR(A[0],C,B,?);", "I:A[0]=9;C.UL=1"),
        ("FFL FFU", "L BOOL, U BOOL, C CONTROL 2, A DINT[2], V DINT 5, W DINT", "XIC(L)FFL(V,A[0],C,?,?);\nXIC(U)FFU(A[0],W,C,?,?);", "pre:C.EN=1;C.EU=1\n:C.EM=1\nL:A[0]=5;C.POS=1\nL=0:C.POS=1\nV=6,L:C.POS=2;C.DN=1\nL=0,U:W=5;A[0]=6;A[1]=0;C.POS=1\nU=0:W=5\nU:W=6;C.EM=1\nU=0:W=6\nU:W=0"),
        ("LFL LFU", "L BOOL, U BOOL, C CONTROL 3, A DINT[3], V DINT 5, W DINT", "XIC(L)LFL(V,A[0],C,?,?);\nXIC(U)LFU(A[0],W,C,?,?);", "L=0:C.EM=1\nL:C.POS=1\nL=0:C.POS=1\nV=6,L:C.POS=2\nL=0,U:W=6;C.POS=1"),
        ("SQO", "I BOOL, C CONTROL 2, A DINT[3] 0;16#A5;16#5A, O DINT 16#F00", "XIC(I)SQO(A[0],16#FF,O,C,?,?);", "pre:C.EN=1\n:C.POS=0\nI:C.POS=1;O=16#FA5\n:C.POS=1\nI=0:O=16#FA5\nI:C.POS=2;O=16#F5A;C.DN=1\nI=0:C.POS=2\nI:C.POS=1"),
        ("SQI SQL", "I BOOL, C CONTROL 2, D CONTROL 2, A DINT[3] 7;0;0, N DINT 7, M BOOL", "SQI(A[0],16#F,N,C,?,?)OTE(M);\nXIC(I)SQL(A[0],N,D,?,?);", ":M=1\nN=8,I:A[1]=8;D.POS=1;M=0"),
    ];
    run(rows);
}

#[test]
fn texts() {
    #[rustfmt::skip]
    let rows: &[Row] = &[
        ("CONCAT", "A STRING ab, B STRING cd, C STRING", "CONCAT(A,B,C);", ":C='abcd'"),
        ("MID DELETE INSERT", "A STRING abcdef, B STRING, C STRING, D STRING", "MID(A,2,3,B);\nDELETE(A,2,3,C);\nINSERT(A,B,1,D);", ":B='cd';C='abef';D='cdabcdef'"),
        ("outside", "A STRING abc, B STRING x, V BOOL", "MID(A,2,0,B);\nXIC(S:V)OTE(V);", ":B='x';V=1"),
        ("FIND", "A STRING abcabc, B STRING c, N DINT, M DINT", "FIND(A,B,1,N);\nFIND(A,B,4,M);", ":N=3;M=6"),
        ("DTOS STOD", "A STRING, N DINT, B STRING x-12y34", "DTOS(-45,A);\nSTOD(B,N);", ":A='-45';N=-12"),
        ("RTOS STOR", "A STRING, B STRING v=2.5e1, R REAL, X REAL 15.3001", "RTOS(X,A);\nSTOR(B,R);", ":A='15.3001003';R=25"),
        ("UPPER LOWER", "A STRING aB1, B STRING, C STRING", "UPPER(A,B);\nLOWER(A,C);", ":B='AB1';C='ab1'"),
    ];
    run(rows);
}

#[test]
fn control_of_execution() {
    #[rustfmt::skip]
    let rows: &[Routines] = &[
        ("JMP forwards and backwards", "N DINT, A DINT", &[("Main", "LBL(again)ADD(N,1,N);\nLES(N,5)JMP(again);\nJMP(end);\nMOV(1,A);\nLBL(end)NOP();")], ":N=5;A=0"),
        ("JSR with values by type", "A DINT[3] 1;2;3, B DINT[3], R REAL, P REAL, Q DINT[3]", &[("Main", "JSR(Sub,2,7,A,R,B);"), ("Sub", "SBR(P,Q);\nRET(P,Q);")], ":R=7;B[2]=3"),
        ("TND and RET in a subroutine", "N DINT, M DINT", &[("Main", "JSR(Sub,0);\nMOV(1,M);\nTND();\nMOV(2,M);"), ("Sub", "MOV(1,N);\nRET();\nMOV(2,N);")], ":N=1;M=1"),
        ("a false JSR runs nothing", "I BOOL, A BOOL 1", &[("Main", "XIC(I)JSR(Sub);"), ("Sub", "OTE(A);")], "pre:A=0\nA:A=1\nI:A=1"),
        ("prescan follows JSR", "A BOOL 1, I BOOL, T TIMER 50", &[("Main", "XIC(I)JSR(Sub,0);"), ("Sub", "OTE(A);\nJSR(Main,0);")], "pre:A=0"),
        ("FOR and BRK", "I DINT, N DINT", &[("Main", "FOR(Sub,I,1,10,2);"), ("Sub", "ADD(N,I,N);\nEQU(I,7)BRK();")], ":N=16;I=7"),
        ("FOR to its end", "I DINT, N DINT", &[("Main", "FOR(Sub,I,1,10,2);"), ("Sub", "ADD(N,I,N);")], ":N=25;I=11"),
        ("MCR", "M BOOL, A BOOL, B BOOL", &[("Main", "XIC(M)MCR();\nOTE(A);\nMCR();\nOTE(B);")], "M:A=1;B=1\nM=0:A=0;B=1"),
        ("first scan", "N DINT, M DINT", &[("Main", "XIC(S:FS)ADD(N,1,N);\nXIC(s:fs)ADD(M,1,M);")], ":N=1\n2 x:N=1;M=1"),
        ("UID UIE", "A BOOL", &[("Main", "UID();\nUIE()OTE(A);")], ":A=1"),
    ];
    for (why, tags, routines, lines) in rows {
        script(why, &project(tags, routines), lines);
    }
}

#[test]
fn structured_text() {
    #[rustfmt::skip]
    let rows: &[Row] = &[
        ("integers", "A DINT, B DINT, C LINT, D REAL", "ST\nA := 7 / 2; B := -7 MOD 3; C := 4294967296 * 4; D := 7 / 2;", ":A=3;B=-1;C=17179869184;D=3"),
        ("logic by type", "X BOOL 1, Y BOOL, N DINT 12, A DINT, B BOOL", "ST\nA := N AND 10; B := X AND NOT Y;", ":A=8;B=1"),
        ("the order of = and &", "X BOOL 1, S DINT, B BOOL", "ST\nIF X & S = 0 THEN B := 1; END_IF;", ":B=1"),
        ("loops and EXIT", "I DINT, N DINT", "ST\nFOR I := 1 TO 10 DO IF I = 4 THEN EXIT; END_IF; N := N + I; END_FOR;", ":N=6;I=4"),
        ("FOR downwards ends one step past", "I DINT, N DINT", "ST\nFOR I := 3 TO 1 BY -1 DO N := N + 1; END_FOR;", ":N=3;I=0"),
        ("not retentive", "A DINT 5, B DINT 5", "ST\nIF S:FS THEN ; END_IF;\nIF B = 99 THEN A [:=] 1; END_IF;", "pre:A=0;B=5"),
        ("texts", "S STRING, T STRING abc", "ST\nS := T;", ":S='abc'"),
        ("functions", "R REAL, N DINT", "ST\nR := SQRT(16.0) + ABS(-1); N := TRUNC(2.9);", ":R=5;N=2"),
        ("instructions", "A DINT[3] 1;2;3, B DINT[3], N DINT", "ST\nCOP(A[0], B[0], 3); SIZE(A, 0, N);", ":B[2]=3;N=3"),
        ("comments and regions", "N DINT", "ST\n#region a\n// b\n(* c\nd *) N := /* e */ 1;\n#endregion", ":N=1"),
        ("CASE with ranges", "N DINT 4, A DINT", "ST\nCASE N OF\n1, 2: A := 1;\n3..5: A := 2; A := A + 1;\nELSE A := 9;\nEND_CASE;", ":A=3\nN=7:A=9\nN=2:A=1"),
        ("a loop of real numbers", "R REAL 0.1, S REAL", "ST\nS := R + R + R;", ":S=0.3"),
    ];
    run(rows);
}

#[test]
fn system_values() {
    #[rustfmt::skip]
    let rows: &[Row] = &[
        ("the clock", "D DINT[7]", "GSV(WallClockTime,,LocalDateTime,D[0]);", ":D[0]=2026;D[6]=6"),
        ("a task", "N DINT, M DINT", "GSV(Task,THIS,Rate,N);\nGSV(Task,Task,Watchdog,M);", ":N=10000;M=500000"),
        ("the names of what runs", "P STRING, T STRING, R STRING, N DINT", "GSV(Program,THIS,Name,P);\nGSV(Task,THIS,Name,T);\nGSV(Routine,THIS,Name,R);\nFIND(T,'ask',1,N);", ":P.LEN=4;P.DATA[0]=77;P.DATA[3]=110;T.LEN=4;N=2;R.LEN=4"),
        ("the names of others", "P STRING, T STRING", "GSV(Program,Main,Name,P);\nGSV(Task,Task,Name,T);", ":P.LEN=4;P.DATA[1]=97;T.DATA[0]=84"),
        ("the controller", "C INT, R INT, D SINT[33] 9", "GSV(ControllerDevice,,ProductCode,C);\nGSV(ControllerDevice,,ProductRev,R);\nGSV(ControllerDevice,,DeviceName,D[0]);", ":C=1;R=2849;D[0]=0"),
        ("an attribute that is smaller keeps the rest", "N DINT -1", "GSV(Program,Main,DisableFlag,N);", ":N=-256"),
        ("a message without answer", "I BOOL 1, M MESSAGE", "XIC(I)MSG(M);", ":M.EN=1;M.ER=0\nM.UnconnectedTimeout=50000:M.EN=1"),
    ];
    run(rows);
}

#[test]
fn instructions_that_do_not_fit_are_named() {
    #[rustfmt::skip]
    let cases = [
        ("XIC(N)OTE(B);", "XIC(N): Data Bit N: N is no BOOL and no bit"),
        ("OTE(Nothing);", "OTE(Nothing): Data Bit Nothing: there is no tag Nothing"),
        ("ADD(1,2);", "ADD(1,2): 2 operands, expected 3"),
        ("MOV(1,A[9]);", "MOV(1,A[9]): Dest A[9]: subscript 9, the array has 3 elements"),
        ("JMP(away);", "JMP(away): Label away: the routine has no such label (4/42)"),
        ("TON(N,?,?);", "TON(N,?,?): Timer N: is DINT, expected TIMER"),
        ("PID(N);", "instruction PID is not supported"),
        ("JSR(Gone,0);", "JSR(Gone,0): there is no routine Gone"),
    ];
    for (rung, expected) in cases {
        let project = project("N DINT, B BOOL, A DINT[3]", &[("Main", rung)]);
        let findings = load(&project, &mut NoMachine).findings;
        let told: Vec<String> = findings.iter().map(ToString::to_string).collect();
        assert_eq!(told, [format!("Main/Main rung 0: {expected}")], "{rung}");
    }
}

#[test]
fn every_row_of_the_table_has_a_test() {
    let tests = concat!(
        include_str!("effects.rs"),
        include_str!("instructions.rs"),
        include_str!("projects.rs")
    );
    for row in crate::table::ROWS {
        let has = |name: &&str| tests.contains(&format!("{name}(")) || tests.contains(&format!("{name} "));
        assert!(row.names.iter().any(has), "{} has no test", row.name());
    }
}
