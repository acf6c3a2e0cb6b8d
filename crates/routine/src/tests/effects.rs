//! Every row of the table of instructions with each effect that it lists (spec/programs.md §10): after prescan, with a false rung, with a
//! true one, and with one that stays true. A row of the table without a case here fails.

use std::collections::{BTreeMap, BTreeSet};

use super::{NoMachine, expect, project, routine, script, set, started};
use crate::source::{Access, MemberSource, Project, TaskSource, Trigger, TypeSource};
use crate::table::{Form, ROWS, Row};

/// Mnemonic, tags, the call, the destination before, and after a true rung.
type WriteCase = (&'static str, &'static str, &'static str, &'static str, &'static str);
/// Mnemonic, tags, the call, tags for a true condition, and for a false one.
type ConditionCase = (&'static str, &'static str, &'static str, &'static str, &'static str);
/// Mnemonic, tags, rungs or text, and a script whose lines begin with the effect that they show.
type EffectCase = (&'static str, &'static str, &'static str, &'static str);

/// Instructions that write to their destination in each scan with a true rung, and do nothing else.
#[rustfmt::skip]
const WRITTEN: &[WriteCase] = &[
    ("OTL", "D BOOL", "OTL(D)", "D=0", "D=1"),
    ("OTU", "D BOOL 1", "OTU(D)", "D=1", "D=0"),
    ("CPT", "D DINT 9", "CPT(D,2+3)", "D=9", "D=5"),
    ("ADD", "D DINT 9", "ADD(2,3,D)", "D=9", "D=5"),
    ("SUB", "D DINT 9", "SUB(2,3,D)", "D=9", "D=-1"),
    ("MUL", "D DINT 9", "MUL(2,3,D)", "D=9", "D=6"),
    ("DIV", "D DINT 9", "DIV(-7,2,D)", "D=9", "D=-3"),
    ("MOD", "D DINT 9", "MOD(-7,2,D)", "D=9", "D=-1"),
    ("XPY", "D DINT 9", "XPY(2,10,D)", "D=9", "D=1024"),
    ("AND", "D DINT 9", "AND(12,10,D)", "D=9", "D=8"),
    ("OR", "D DINT 9", "OR(12,10,D)", "D=9", "D=14"),
    ("XOR", "D DINT 9", "XOR(12,10,D)", "D=9", "D=6"),
    ("NOT", "D DINT 9", "NOT(0,D)", "D=9", "D=-1"),
    ("NEG", "D DINT 9", "NEG(4,D)", "D=9", "D=-4"),
    ("ABS", "D DINT 9", "ABS(-4,D)", "D=9", "D=4"),
    ("SQR", "D DINT 9", "SQR(16,D)", "D=9", "D=4"),
    ("SIN", "D REAL 9", "SIN(0.5,D)", "D=9", "D>0.4794;D<0.4795"),
    ("COS", "D REAL 9", "COS(0.5,D)", "D=9", "D>0.8775;D<0.8776"),
    ("TAN", "D REAL 9", "TAN(0.5,D)", "D=9", "D>0.5463;D<0.5464"),
    ("ASN", "D REAL 9", "ASN(0.5,D)", "D=9", "D>0.5235;D<0.5236"),
    ("ACS", "D REAL 9", "ACS(0.5,D)", "D=9", "D>1.0471;D<1.0472"),
    ("ATN", "D REAL 9", "ATN(0.5,D)", "D=9", "D>0.4636;D<0.4637"),
    ("LN", "D REAL 9", "LN(2.0,D)", "D=9", "D>0.6931;D<0.6932"),
    ("LOG", "D REAL 9", "LOG(100.0,D)", "D=9", "D=2"),
    ("DEG", "D REAL 9", "DEG(1.0,D)", "D=9", "D>57.295;D<57.296"),
    ("RAD", "D REAL 9", "RAD(90.0,D)", "D=9", "D>1.5707;D<1.5708"),
    ("TRN", "D DINT 9", "TRN(-2.7,D)", "D=9", "D=-2"),
    ("TOD", "D DINT 9", "TOD(1234,D)", "D=9", "D=16#1234"),
    ("FRD", "D DINT 9", "FRD(16#1234,D)", "D=9", "D=1234"),
    ("CLR", "D DINT 9", "CLR(D)", "D=9", "D=0"),
    ("MOV", "D DINT 9", "MOV(7,D)", "D=9", "D=7"),
    ("MVM", "D DINT 16#90", "MVM(16#FF,16#F,D)", "D=16#90", "D=16#9F"),
    ("BTD", "D DINT 1", "BTD(3,0,D,4,2)", "D=1", "D=49"),
    ("SWPB", "D DINT 9", "SWPB(16#12345678,WORD,D)", "D=9", "D=16#56781234"),
    ("COP", "S DINT 5, D DINT 9", "COP(S,D,1)", "D=9", "D=5"),
    ("CPS", "S DINT[2] 5;6, D DINT[2] 9;9", "CPS(S[0],D[0],2)", "D[0]=9", "D[0]=5;D[1]=6"),
    ("FLL", "D DINT[3] 9;9;9", "FLL(7,D[0],2)", "D[0]=9", "D[0]=7;D[1]=7;D[2]=9"),
    ("SIZE", "A DINT[3;5], D DINT 9", "SIZE(A,1,D)", "D=9", "D=5"),
    ("CONCAT", "A STRING ab, B STRING cd, D STRING x", "CONCAT(A,B,D)", "D='x'", "D='abcd'"),
    ("MID", "A STRING abcd, D STRING x", "MID(A,2,2,D)", "D='x'", "D='bc'"),
    ("DELETE", "A STRING abcd, D STRING x", "DELETE(A,2,2,D)", "D='x'", "D='ad'"),
    ("INSERT", "A STRING ad, B STRING bc, D STRING x", "INSERT(A,B,2,D)", "D='x'", "D='abcd'"),
    ("FIND", "A STRING abcabc, B STRING c, D DINT 9", "FIND(A,B,4,D)", "D=9", "D=6"),
    ("DTOS", "D STRING x", "DTOS(-45,D)", "D='x'", "D='-45'"),
    ("STOD", "A STRING x-12y, D DINT 9", "STOD(A,D)", "D=9", "D=-12"),
    ("RTOS", "D STRING x", "RTOS(2.5,D)", "D='x'", "D='2.5'"),
    ("STOR", "A STRING x2.5y, D REAL 9", "STOR(A,D)", "D=9", "D=2.5"),
    ("UPPER", "A STRING aB1, D STRING x", "UPPER(A,D)", "D='x'", "D='AB1'"),
    ("LOWER", "A STRING aB1, D STRING x", "LOWER(A,D)", "D='x'", "D='ab1'"),
    ("GSV", "D DINT 9", "GSV(Task,THIS,Rate,D)", "D=9", "D=10000"),
    ("NOP", "D DINT 9", "NOP()MOV(1,D)", "D=9", "D=1"),
    ("UID", "D DINT 9", "UID()UIE()MOV(1,D)", "D=9", "D=1"),
];

/// Conditions, which evaluate nothing and pass nothing on with a false rung.
#[rustfmt::skip]
const ASKED: &[ConditionCase] = &[
    ("XIC", "B BOOL", "XIC(B)", "B=1", "B=0"),
    ("XIO", "B BOOL", "XIO(B)", "B=0", "B=1"),
    ("EQU", "N DINT", "EQU(N,5)", "N=5", "N=4"),
    ("NEQ", "N DINT", "NEQ(N,5)", "N=4", "N=5"),
    ("GRT", "N DINT", "GRT(N,5)", "N=6", "N=5"),
    ("GEQ", "N DINT", "GEQ(N,5)", "N=5", "N=4"),
    ("LES", "N DINT", "LES(N,5)", "N=4", "N=5"),
    ("LEQ", "N DINT", "LEQ(N,5)", "N=5", "N=6"),
    ("LIM", "N DINT", "LIM(2,N,5)", "N=5", "N=6"),
    ("MEQ", "N DINT", "MEQ(N,16#F,5)", "N=16#25", "N=6"),
    ("CMP", "N DINT", "CMP(N*2>9)", "N=5", "N=4"),
    ("SQI", "N DINT, A DINT[3] 0;7;8, C CONTROL 2", "SQI(A[0],16#F,N,C,?,?)", "C.POS=1,N=7", "C.POS=1,N=6"),
];

/// All others, each with lines for its effects.
#[rustfmt::skip]
const SHOWN: &[EffectCase] = &[
    ("OTE", "I BOOL, D BOOL 1", "XIC(I)OTE(D);", "pre:D=0\nfalse D:D=0\ntrue I:D=1\nagain D=0:D=1"),
    ("AFI", "I BOOL, D BOOL 1", "XIC(I)AFI()OTE(D);", "pre:D=0\nfalse D:D=0\ntrue I,D:D=0\nagain D:D=0"),
    ("ONS", "I BOOL, S BOOL, D BOOL", "XIC(I)ONS(S)OTE(D);", "pre:S=1;D=0\nfalse :S=0;D=0\ntrue I:S=1;D=1\nagain :S=1;D=0"),
    ("OSR", "I BOOL, S BOOL, O BOOL 1, D BOOL", "XIC(I)OSR(S,O)OTE(D);", "pre:S=1;O=0\nfalse O:S=0;O=0;D=0\ntrue I:S=1;O=1;D=1\nagain :S=1;O=0;D=1"),
    ("OSF", "I BOOL, S BOOL 1, O BOOL 1, D BOOL", "XIC(I)OSF(S,O)OTE(D);", "pre:S=0;O=0\ntrue I:S=1;O=0;D=1\nagain O:S=1;O=0\nfalse I=0:S=0;O=1;D=0\nfalse :O=0"),
    ("TON", "I BOOL, T TIMER 30", "XIC(I)TON(T,?,?);", "false T.ACC=5,T.DN,T.EN,T.TT:T.ACC=0;T.DN=0;T.EN=0;T.TT=0\ntrue I:T.EN=1;T.TT=1;T.DN=0;T.ACC=0\nagain :T.ACC=10\nagain 2 x:T.ACC=30;T.DN=1;T.TT=0;T.EN=1"),
    ("TOF", "I BOOL, T TIMER 20", "XIC(I)TOF(T,?,?);", "true I:T.EN=1;T.DN=1;T.TT=0;T.ACC=0\nagain T.ACC=7:T.ACC=0;T.DN=1\nfalse I=0:T.EN=0;T.TT=1;T.DN=1;T.ACC=0\nfalse :T.ACC=10\nfalse :T.ACC=20;T.DN=0;T.TT=0\nfalse :T.ACC=20"),
    ("RTO", "I BOOL, T TIMER 30", "XIC(I)RTO(T,?,?);", "false T.ACC=5,T.DN,T.EN,T.TT:T.ACC=5;T.DN=1;T.EN=0;T.TT=0\ntrue T.DN=0,I:T.EN=1;T.TT=1;T.ACC=5\nagain :T.ACC=15\nagain 2 x:T.ACC=35;T.DN=1;T.TT=0"),
    ("CTU", "I BOOL, C COUNTER 2", "XIC(I)CTU(C,?,?);", "pre:C.CU=1;C.ACC=0\nfalse :C.CU=0;C.ACC=0\ntrue I:C.CU=1;C.ACC=1;C.DN=0\nagain :C.ACC=1\nfalse I=0:C.CU=0;C.ACC=1\ntrue I:C.ACC=2;C.DN=1"),
    ("CTD", "I BOOL, C COUNTER 0", "XIC(I)CTD(C,?,?);", "pre:C.CD=1;C.ACC=0\nfalse :C.CD=0;C.ACC=0;C.DN=1\ntrue I:C.CD=1;C.ACC=-1;C.DN=0\nagain :C.ACC=-1"),
    ("RES", "I BOOL, T TIMER 9, C COUNTER 9, K CONTROL 9", "XIC(I)RES(T)RES(C)RES(K);",
        "false T.ACC=5,T.DN,C.ACC=6,C.OV,C.CU,K.POS=7,K.DN:T.ACC=5;T.DN=1;C.ACC=6;C.OV=1;K.POS=7\ntrue I:T.ACC=0;T.DN=0;T.PRE=9;C.ACC=0;C.OV=0;C.CU=0;K.POS=0;K.DN=0;K.LEN=9\nagain C.ACC=3:C.ACC=0"),
    ("EVENT", "I BOOL, N DINT", "XIC(I)EVENT(Other);", "pre:N=0\nfalse :N=0\ntrue I:N=1\nagain :N=2"),
    ("SSV", "I BOOL, N DINT 5, R DINT", "XIC(I)SSV(FaultLog,,MinorFaultBits,N);\nGSV(FaultLog,,MinorFaultBits,R);", "pre:R=0\nfalse :R=0\ntrue I:R=5\nagain N=6:R=6"),
    ("MSG", "I BOOL, M MESSAGE", "XIC(I)MSG(M);", "false M.EN,M.DN:M.EN=0\nfalse M.EN,M.DN=0:M.EN=1\ntrue M.EN=0,I:M.EN=1;M.EW=1;M.DN=0\nagain M.EW=0:M.EW=0"),
    ("ALMD", "I BOOL, P BOOL, Q BOOL, E BOOL, F BOOL, A ALARM_DIGITAL", "XIC(I)ALMD(A,P,Q,E,F,?,?);",
        "false A.Condition,A.AckRequired,A.MinDurationPRE=20:A.In=0;A.InAlarm=0;A.Acked\ntrue I:A.In;A.InAlarm=0;A.MinDurationACC=0\nagain :A.MinDurationACC=10;A.InAlarm=0\nagain :A.InAlarm;A.Acked=0;A.InAlarmUnack;A.AlarmCount=1\nagain P:A.Acked;A.InAlarmUnack=0;A.InAlarm\nfalse I=0:A.InAlarm=0;A.MinDurationACC=0;A.Acked"),
    ("FAL", "I BOOL, C CONTROL 3, D DINT[3]", "XIC(I)FAL(C,?,?,ALL,D[C.POS],C.POS+1);", "false C.EN,C.DN:C.EN=0;D[0]=0\ntrue I:D[0]=1;D[2]=3;C.DN=1;C.EN=1;C.POS=3\nagain D[0]=9:D[0]=9"),
    ("FSC", "I BOOL, C CONTROL 4, A DINT[4] 5;6;7;8", "XIC(I)FSC(C,?,?,ALL,A[C.POS]>6);", "false C.EN,C.DN:C.EN=0;C.FD=0\ntrue I:C.FD=1;C.IN=1;C.POS=2;C.EN=1\nagain :C.POS=2"),
    ("AVE", "I BOOL, C CONTROL 4, A REAL[4] 1;2;3;4, D REAL 9", "XIC(I)AVE(A[0],0,D,C,?,?);", "false C.EN,C.DN,C.ER:C.EN=0;C.DN=0;C.ER=0;D=9\ntrue I:D=2.5;C.EN=1;C.DN=1;C.POS=4\nagain D=9:D=9"),
    ("STD", "I BOOL, C CONTROL 4, A REAL[4] 1;2;3;4, D REAL 9", "XIC(I)STD(A[0],0,D,C,?,?);", "false C.EN,C.DN,C.ER:C.EN=0;C.DN=0;C.ER=0;D=9\ntrue I:D>1.2909;D<1.291;C.DN=1\nagain D=9:D=9"),
    ("SRT", "I BOOL, C CONTROL 3, A DINT[3] 3;1;2", "XIC(I)SRT(A[0],0,C,?,?);", "false C.EN,C.DN,C.ER:C.EN=0;C.DN=0;C.ER=0;A[0]=3\ntrue I:A[0]=1;A[1]=2;A[2]=3;C.DN=1\nagain A[0]=9:A[0]=9"),
    ("BSL", "I BOOL, B BOOL 1, C CONTROL 4, A DINT[1] 8", "XIC(I)BSL(A[0],C,B,?);", "false C.EN,C.DN,C.ER,C.UL,C.POS=4:C.EN=0;C.DN=0;C.ER=0;C.UL=0;C.POS=0;A[0]=8\ntrue I:A[0]=1;C.UL=1;C.EN=1;C.DN=1;C.POS=4\nagain :A[0]=1"),
    ("BSR", "I BOOL, B BOOL 1, C CONTROL 4, A DINT[1] 3", "XIC(I)BSR(A[0],C,B,?);", "false C.EN,C.DN,C.ER,C.UL,C.POS=4:C.EN=0;C.DN=0;C.ER=0;C.UL=0;C.POS=0;A[0]=3\ntrue I:A[0]=9;C.UL=1;C.EN=1;C.DN=1;C.POS=4\nagain :A[0]=9"),
    ("FFL", "I BOOL, C CONTROL 2, A DINT[2], V DINT 5", "XIC(I)FFL(V,A[0],C,?,?);", "pre:C.EN=1;C.POS=0\nfalse :C.EN=0;C.EM=1;C.POS=0\ntrue I:C.EN=1;A[0]=5;C.POS=1;C.EM=0;C.DN=0\nagain :C.POS=1"),
    ("FFU", "I BOOL, C CONTROL 3, A DINT[3] 5;6;7, D DINT 9", "XIC(I)FFU(A[0],D,C,?,?);", "pre:C.EU=1;D=9\nfalse C.POS=3:C.EU=0;D=9;C.DN=1\ntrue I:C.EU=1;D=5;A[0]=6;A[1]=7;A[2]=0;C.POS=2;C.DN=0\nagain :C.POS=2"),
    ("LFL", "I BOOL, C CONTROL 2, A DINT[2], V DINT 5", "XIC(I)LFL(V,A[0],C,?,?);", "pre:C.EN=1;C.POS=0\nfalse :C.EN=0;C.EM=1;C.POS=0\ntrue I:C.EN=1;A[0]=5;C.POS=1;C.EM=0\nagain :C.POS=1\nfalse I=0:C.EN=0;C.POS=1\ntrue I:A[1]=5;C.DN=1"),
    ("LFU", "I BOOL, C CONTROL 3, A DINT[3] 5;6;7, D DINT 9", "XIC(I)LFU(A[0],D,C,?,?);", "pre:C.EU=1;D=9\nfalse C.POS=3:C.EU=0;D=9\ntrue I:C.EU=1;D=7;A[2]=0;C.POS=2\nagain :C.POS=2"),
    ("SQO", "I BOOL, C CONTROL 2, A DINT[3] 0;5;6, D DINT 16#F0", "XIC(I)SQO(A[0],16#F,D,C,?,?);", "pre:C.EN=1;C.POS=0\nfalse :C.EN=0;C.POS=0;D=16#F0\ntrue I:C.POS=1;D=16#F5;C.EN=1;C.DN=0\nagain :C.POS=1"),
    ("SQL", "I BOOL, C CONTROL 2, A DINT[3], V DINT 5", "XIC(I)SQL(A[0],V,C,?,?);", "pre:C.EN=1;C.POS=0\nfalse :C.EN=0;C.POS=0\ntrue I:C.POS=1;A[1]=5;C.EN=1\nagain :C.POS=1;A[2]=0"),
    ("MCR", "I BOOL, D BOOL, N DINT", "XIC(I)MCR();\nOTE(D);\nADD(N,1,N);\nMCR();", "pre:D=0;N=0\nfalse D:D=0;N=0\ntrue I:D=1;N=1\nagain :D=1;N=2"),
    ("OSRI", "F FBD_ONESHOT", "ST\nOSRI(F);", "pre:F.OutputBit=0\ntrue F.InputBit=0:F.OutputBit=0\ntrue F.InputBit:F.OutputBit=1\nagain :F.OutputBit=0"),
    ("OSFI", "F FBD_ONESHOT", "ST\nOSFI(F);", "pre:F.OutputBit=0\ntrue F.InputBit:F.OutputBit=0\ntrue F.InputBit=0:F.OutputBit=1\nagain :F.OutputBit=0"),
    ("TONR", "F FBD_TIMER", "ST\nTONR(F);", "pre:F.ACC=0\ntrue F.PRE=20,F.TimerEnable:F.EN=1;F.TT=1\nagain 2 x:F.ACC=20;F.DN=1"),
    ("TOFR", "F FBD_TIMER", "ST\nTOFR(F);", "pre:F.DN=0\ntrue F.PRE=10,F.TimerEnable:F.DN=1\ntrue F.TimerEnable=0:F.DN=1;F.TT=1\nagain :F.DN=0"),
    ("RTOR", "F FBD_TIMER", "ST\nRTOR(F);", "pre:F.EN=0\ntrue F.PRE=90,F.TimerEnable:F.ACC=0;F.EN=1\nagain :F.ACC=10\ntrue F.TimerEnable=0:F.ACC=10;F.TT=0"),
    ("CTUD", "F FBD_COUNTER", "ST\nCTUD(F);", "pre:F.ACC=0;F.CU=1\ntrue :F.CU=0\ntrue F.CUEnable:F.ACC=1\nagain :F.ACC=1"),
    ("MVMT", "F FBD_MASKED_MOVE", "ST\nMVMT(F);", "pre:F.Dest=0\ntrue F.Source=15,F.Mask=3,F.Target=8:F.Dest=11\nagain F.Dest=0:F.Dest=11"),
    ("BTDT", "F FBD_BIT_FIELD_DISTRIBUTE", "ST\nBTDT(F);", "pre:F.Dest=0\ntrue F.Source=3,F.Length=2,F.DestBit=4,F.Target=1:F.Dest=49\nagain F.Dest=0:F.Dest=49"),
];

/// Instructions of the order of execution, with the routine `Sub` behind the rungs of the main one.
#[rustfmt::skip]
const CONTROLLED: &[(&str, &str, &str, &str, &str)] = &[
    ("JSR", "I BOOL, D BOOL 1, N DINT", "XIC(I)JSR(Sub,0);", "OTE(D);\nADD(N,1,N);", "pre:D=0;N=0\nfalse D:D=1;N=0\ntrue I:N=1\nagain :N=2"),
    ("SBR", "I BOOL, P DINT 9, N DINT", "XIC(I)JSR(Sub,1,5,N);", "SBR(P)ADD(P,1,P);\nRET(P);", "pre:P=9;N=0\nfalse :P=9;N=0\ntrue I:P=6;N=6\nagain :P=6"),
    ("RET", "I BOOL, N DINT", "JSR(Sub,0);", "XIC(I)RET();\nADD(N,1,N);", "pre:N=0\nfalse :N=1\ntrue I:N=1\nagain :N=1"),
    ("JMP", "I BOOL, N DINT", "XIC(I)JMP(x);\nADD(N,1,N);\nLBL(x)JSR(Sub,0);", "NOP();", "pre:N=0\nfalse :N=1\ntrue I:N=1\nagain :N=1"),
    ("LBL", "I BOOL, N DINT", "XIC(I)JMP(x);\nNOP();\nLBL(x)ADD(N,1,N);\nJSR(Sub,0);", "NOP();", "pre:N=0\nfalse :N=1\ntrue I:N=2\nagain :N=3"),
    ("TND", "I BOOL, N DINT", "JSR(Sub,0);", "XIC(I)TND();\nADD(N,1,N);", "pre:N=0\nfalse :N=1\ntrue I:N=1\nagain :N=1"),
    ("FOR", "I BOOL, K DINT 9, D BOOL 1, N DINT", "XIC(I)FOR(Sub,K,0,2,1);", "OTE(D);\nADD(N,1,N);", "pre:D=0;N=0;K=9\nfalse D:D=1;K=9;N=0\ntrue I:N=3;K=3\nagain :N=6"),
    ("BRK", "I BOOL, K DINT, N DINT", "FOR(Sub,K,0,2,1);", "ADD(N,1,N);\nXIC(I)BRK();", "pre:N=0\nfalse :N=3\ntrue I:N=4;K=0\nagain :N=5"),
];

/// The scripts of all instructions by mnemonic.
fn cases() -> Vec<(&'static str, Project, String)> {
    let mut all = Vec::new();
    for (name, tags, call, before, after) in WRITTEN {
        let of = project(&format!("I BOOL, {tags}"), &[("Main", &format!("XIC(I){call};"))]);
        let lines = format!(
            "pre:{before}\nfalse :{before}\ntrue I:{after}\nagain {before}:{after}\nfalse I=0,{before}:{before}"
        );
        all.push((*name, of, lines));
    }
    for (name, tags, call, yes, no) in ASKED {
        let of = project(
            &format!("I BOOL, O BOOL 1, {tags}"),
            &[("Main", &format!("XIC(I){call}OTE(O);"))],
        );
        let lines =
            format!("pre:O=0\nfalse {yes}:O=0\ntrue I,{yes}:O=1\nagain :O=1\ntrue {no}:O=0\nfalse I=0,{yes}:O=0");
        all.push((*name, of, lines));
    }
    for (name, tags, rungs, lines) in SHOWN {
        let mut of = project(tags, &[("Main", rungs)]);
        if *name == "EVENT" {
            let mut other = of.programs[0].clone();
            other.name = "Counting".to_owned();
            other.routines = vec![routine("Main", "ADD(N,1,N);")];
            of.programs.push(other);
            let trigger = Trigger::Event("EVENT Instruction Only".to_owned(), None);
            of.tasks.push(TaskSource::new("Other", trigger, &["Counting"]));
        }
        // The effects of prescan on members show only if the members do not begin with 0.
        let lines = match *name {
            "TON" => started_with(&of, "T.EN,T.TT,T.DN,T.ACC=7", "T.EN=0;T.TT=0;T.DN=0;T.ACC=0", lines),
            "TOF" => started_with(&of, "T.EN,T.TT,T.DN,T.ACC=7", "T.EN=0;T.TT=0;T.DN=0;T.ACC=20", lines),
            "RTO" => started_with(&of, "T.EN,T.TT,T.DN,T.ACC=7", "T.EN=0;T.TT=0;T.DN=1;T.ACC=7", lines),
            "RES" => started_with(&of, "T.ACC=7,T.DN", "T.ACC=7;T.DN=1", lines),
            "ALMD" => started_with(
                &of,
                "A.InAlarm,A.InAlarmUnack,A.OperAck,A.MinDurationACC=7",
                "A.InAlarm=0;A.Acked=1;A.InAlarmUnack=0;A.OperAck=0;A.MinDurationACC=0",
                lines,
            ),
            "MSG" => started_with(&of, "M.EN,M.DN", "M.EN=0;M.DN=1", lines),
            "FAL" | "FSC" => started_with(&of, "C.EN,C.DN,C.POS=2", "C.EN=0;C.DN=1;C.POS=2", lines),
            "AVE" | "STD" | "SRT" => started_with(&of, "C.EN,C.DN,C.ER,C.POS=2", "C.EN=0;C.DN=0;C.ER=0;C.POS=2", lines),
            "BSL" | "BSR" => started_with(
                &of,
                "C.EN,C.DN,C.ER,C.UL,C.POS=2",
                "C.EN=0;C.DN=0;C.ER=0;C.UL=0;C.POS=0",
                lines,
            ),
            _ => (*lines).to_owned(),
        };
        all.push((*name, of, lines));
    }
    for (name, tags, main, sub, lines) in CONTROLLED {
        all.push((
            *name,
            project(tags, &[("Main", main), ("Sub", sub)]),
            (*lines).to_owned(),
        ));
    }
    all
}

/// Checks the effects of prescan on members with values, and returns the script with a line for it.
fn started_with(of: &Project, sets: &str, expected: &str, lines: &str) -> String {
    let why = format!("prescan of {sets}");
    let mut cell = started(&why, of);
    sets.split(',').for_each(|text| set(&why, &mut cell, of, text));
    cell.start(0, &mut NoMachine)
        .unwrap_or_else(|fault| panic!("{why}: {fault}"));
    expected.split(';').for_each(|text| expect(&why, &mut cell, of, text));
    format!("pre:\n{lines}")
}

#[test]
fn every_instruction_has_the_effects_of_its_row() {
    let mut seen: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let mut scripts = Vec::new();
    for (name, of, lines) in cases() {
        let effects = seen.entry(name).or_default();
        let mut plain = String::new();
        for line in lines.lines() {
            let (effect, rest) = ["false", "true", "again"]
                .into_iter()
                .find_map(|word| Some((word, line.strip_prefix(word)?)))
                .unwrap_or(("pre", line));
            effects.insert(effect);
            plain.push_str(rest.trim());
            plain.push('\n');
        }
        scripts.push((name, of, plain));
    }
    each(&scripts, |(name, of, lines)| {
        script(name, of, lines);
    });
    for row in ROWS {
        let shown: BTreeSet<&str> = row
            .names
            .iter()
            .filter_map(|name| seen.get(name))
            .flatten()
            .copied()
            .collect();
        for effect in needed(row) {
            assert!(shown.contains(effect), "{} has no case for {effect}", row.name());
        }
    }
}

/// The effects that a row needs cases for. The instruction must not have an effect that its row does not list.
fn needed(row: &Row) -> &'static [&'static str] {
    if row.form == Form::Text {
        &["pre", "true", "again"]
    } else {
        &["pre", "false", "true", "again"]
    }
}

fn run(rows: &[EffectCase]) {
    each(rows, |(why, tags, rungs, lines)| {
        script(why, &project(tags, &[("Main", rungs)]), lines);
    });
}

/// Runs all rows, so that a failure names each one that fails.
fn each<T: std::panic::RefUnwindSafe>(rows: &[T], run: impl Fn(&T) + std::panic::RefUnwindSafe) {
    let failed = rows
        .iter()
        .filter_map(|row| std::panic::catch_unwind(|| run(row)).err());
    let words = failed.map(|panic| panic.downcast_ref::<String>().cloned().unwrap_or_default());
    let wrong: Vec<String> = words.collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn values_at_their_ends() {
    #[rustfmt::skip]
    let rows: &[EffectCase] = &[
        ("ACC of TON stays at its end", "I BOOL, T TIMER 2147483647", "XIC(I)TON(T,?,?);", "I:T.ACC=0\nT.ACC=2147483640:T.ACC=2147483647;T.DN=1\n:T.ACC=2147483647"),
        ("ACC of RTO too", "I BOOL, T TIMER 2147483647", "XIC(I)RTO(T,?,?);", "I:T.ACC=0\nT.ACC=2147483640:T.ACC=2147483647;T.DN=1"),
        ("ACC of TOF too", "I BOOL, T TIMER 2147483647", "XIC(I)TOF(T,?,?);", "I:T.DN=1\nI=0:T.TT=1\nT.ACC=2147483640:T.ACC=2147483647;T.DN=0"),
        ("ACC is not cut to PRE", "I BOOL, T TIMER 15", "XIC(I)TON(T,?,?);", "I:T.ACC=0\n2 x:T.ACC=20;T.DN=1"),
        ("DN of TOF, cleared by hand, pauses", "I BOOL, T TIMER 50", "XIC(I)TOF(T,?,?);", "I:T.DN=1\nI=0:T.ACC=0\n:T.ACC=10\nT.DN=0:T.ACC=10\nT.DN:T.ACC=20"),
        ("CTU past the end takes UN back", "I BOOL, C COUNTER 2", "XIC(I)CTU(C,?,?);", ":C.OV=0\nC.UN,C.ACC=2147483647,I:C.ACC=-2147483648;C.UN=0;C.OV=0;C.DN=0"),
        ("CTD past the end takes OV back", "I BOOL, C COUNTER 2", "XIC(I)CTD(C,?,?);", ":C.UN=0\nC.OV,C.ACC=-2147483648,I:C.ACC=2147483647;C.OV=0;C.UN=0;C.DN=1"),
        ("DN stays while OV is set", "I BOOL, C COUNTER 2", "XIC(I)CTU(C,?,?);", ":C.DN=0\nC.ACC=2147483646,I:C.DN=1\nI=0:C.DN=1\nI:C.OV=1;C.DN=1;C.ACC=-2147483648"),
        ("TOD above eight digits", "D DINT 9, V BOOL, M BOOL, E DINT", "TOD(99999999,E);\nTOD(100000000,D);\nXIC(S:V)OTE(V);\nXIC(S:MINOR)OTE(M);", ":E=16#99999999;V=1;M=1"),
        ("TOD of a negative number", "D DINT 9, V BOOL, M BOOL", "TOD(-1,D);\nXIC(S:V)OTE(V);\nXIC(S:MINOR)OTE(M);", ":V=1;M=1"),
        ("FAL stops at an overflow", "I BOOL, C CONTROL 3, A DINT[3] 1;2147483647;3, D DINT[3], V BOOL", "XIC(I)FAL(C,?,?,ALL,D[C.POS],A[C.POS]+1);", "I:D[0]=2;D[2]=0;C.POS=1;C.ER=1;C.DN=0;C.EN=1\n:C.POS=1\nI=0:C.EN=0;C.ER=0"),
        ("FSC goes on when IN is cleared", "I BOOL, C CONTROL 4, A DINT[4] 5;7;6;8", "XIC(I)FSC(C,?,?,ALL,A[C.POS]>6);", "I:C.POS=1;C.FD=1;C.IN=1;C.DN=0\n:C.POS=1\nC.IN=0:C.POS=3;C.FD=1;C.IN=1\nC.IN=0:C.DN=1"),
        ("FSC without a hit", "I BOOL, C CONTROL 3, A DINT[3] 1;2;3", "XIC(I)FSC(C,?,?,ALL,A[C.POS]>6);", "I:C.DN=1;C.FD=0;C.POS=3\nI=0:C.EN=0"),
        ("SQI of a position beyond LEN", "A DINT[3] 7;7;7, C CONTROL 2, O BOOL", "SQI(A[0],16#F,7,C,?,?)OTE(O);", ":O=1;C.ER=0\nC.POS=3:O=0;C.ER=1\nC.POS=-1:O=0;C.ER=1\nC.POS=2:O=1;C.ER=0\nC.LEN=0:O=0;C.ER=1"),
        ("SQO of a length that is none", "I BOOL, A DINT[3] 7;7;7, C CONTROL 0, D DINT 9", "XIC(I)SQO(A[0],-1,D,C,?,?);", ":C.ER=0\nI:C.ER=1;D=9;C.POS=0\nI=0:C.EN=0\nC.LEN=2,I:C.ER=0;D=7;C.POS=1\nI=0:C.POS=1\nC.POS=-1,I:C.ER=1;C.POS=-1"),
        ("BSR by 0 bits", "I BOOL, B BOOL, C CONTROL 0, A DINT[1] 3", "XIC(I)BSR(A[0],C,B,?);", ":C.POS=0\nI:A[0]=3;C.DN=1"),
        ("FFU of an empty queue", "I BOOL, C CONTROL 2, A DINT[2] 5;6, D DINT 9", "XIC(I)FFU(A[0],D,C,?,?);", ":C.EM=1\nI:D=0;A[0]=5;C.POS=0"),
        ("FFL of a full queue", "I BOOL, C CONTROL 2, A DINT[2] 5;6, V DINT 9", "XIC(I)FFL(V,A[0],C,?,?);", "C.POS=2:C.DN=1\nI:A[0]=5;A[1]=6;C.POS=2;C.DN=1"),
        ("a latched alarm stays until it is reset", "I BOOL 1, P BOOL, Q BOOL, E BOOL, F BOOL, A ALARM_DIGITAL", "XIC(I)ALMD(A,P,Q,E,F,?,?);", "A.Condition,A.Latched:A.InAlarm;A.Acked\nQ:A.InAlarm\nI=0:A.InAlarm\nQ=0:A.InAlarm\nQ:A.InAlarm=0\nI:A.InAlarm;A.AlarmCount=2\nI=0,A.OperReset:A.InAlarm=0;A.OperReset=0"),
        ("a disabled alarm", "I BOOL 1, P BOOL, Q BOOL, E BOOL 1, F BOOL, A ALARM_DIGITAL", "XIC(I)ALMD(A,P,Q,E,F,?,?);", "A.Condition:A.Disabled;A.InAlarm=0\nF:A.Disabled=0;A.InAlarm\nF=0:A.Disabled;A.InAlarm=0\nE=0,A.OperEnable:A.Disabled=0;A.InAlarm"),
        ("an alarm of a false input, acknowledged by an operator", "I BOOL, P BOOL, Q BOOL, E BOOL, F BOOL, A ALARM_DIGITAL", "XIC(I)ALMD(A,P,Q,E,F,?,?);", "A.AckRequired:A.InAlarm;A.Acked=0\nA.OperAck:A.Acked;A.OperAck=0\nI:A.InAlarm=0\nA.OperSuppress,I=0:A.InAlarm;A.Suppressed;A.Acked=0\nA.OperUnsuppress:A.Suppressed=0"),
        ("SIZE of an array of BOOLs", "A BOOL[64], D DINT", "SIZE(A,0,D);", ":D=64"),
        ("SIZE of a dimension that is not there", "A DINT[3], D DINT 9", "SIZE(A,2,D);", ":D=0"),
        ("CPS ends at the end", "A DINT[4] 1;2;3;4, B DINT[2], C DINT 9", "CPS(A[0],B[1],9);", ":B[0]=0;B[1]=1;C=9"),
        ("DIV and MOD by 0 of REAL", "A REAL, B REAL, M BOOL, Z REAL", "DIV(7.0,Z,A);\nMOD(7.0,Z,B);\nXIC(S:MINOR)OTE(M);", ":A>1.0e38;B=0;M=1"),
        ("REPEAT", "N DINT, K DINT 5", "ST\nREPEAT N := N + 1; K := K - 1; UNTIL K <= 2 END_REPEAT;", ":N=3;K=2\n:N=4;K=1"),
        ("EXIT of REPEAT", "N DINT", "ST\nREPEAT N := N + 1; IF N = 3 THEN EXIT; END_IF; UNTIL N = 9 END_REPEAT;", ":N=3\n:N=9"),
    ];
    run(rows);
}

#[test]
fn moves_and_sums_of_every_type() {
    #[rustfmt::skip]
    let rows: &[EffectCase] = &[
        ("MOV into SINT keeps the low byte", "D SINT, V BOOL, N BOOL", "MOV(200,D);\nXIC(S:V)OTE(V);\nXIC(S:N)OTE(N);", ":D=-56;V=1;N=1"),
        ("MOV into INT", "D INT, V BOOL", "MOV(70000,D);\nXIC(S:V)OTE(V);", ":D=4464;V=1"),
        ("MOV into DINT from LINT", "S LINT 4294967301, D DINT, V BOOL", "MOV(S,D);\nXIC(S:V)OTE(V);", ":D=5;V=1"),
        ("MOV into LINT extends the sign", "S SINT -3, D LINT, V BOOL", "MOV(S,D);\nXIC(S:V)OTE(V);", ":D=-3;V=0"),
        ("MOV of REAL into INT rounds to even", "S REAL 2.5, T REAL 3.5, D INT, E INT", "MOV(S,D);\nMOV(T,E);", ":D=2;E=4"),
        ("MOV of LREAL into REAL and back", "S LREAL 0.1, D REAL, E LREAL", "MOV(S,D);\nMOV(D,E);", ":D>0.0999;D<0.1001;E<>S"),
        ("MOV of LINT into LREAL", "S LINT 9007199254740991, D LREAL", "MOV(S,D);", ":D=9007199254740991"),
        ("MOV of not a number into DINT", "S REAL 1.#QNAN, D DINT 5, V BOOL", "MOV(S,D);\nXIC(S:V)OTE(V);", ":V=1"),
        ("ADD of SINTs into SINT", "A SINT 100, B SINT 50, D SINT, V BOOL", "ADD(A,B,D);\nXIC(S:V)OTE(V);", ":D=-106;V=1"),
        ("ADD of SINTs into INT", "A SINT 100, B SINT 50, D INT, V BOOL", "ADD(A,B,D);\nXIC(S:V)OTE(V);", ":D=150;V=0"),
        ("ADD of INTs into INT", "A INT 30000, B INT 30000, D INT, V BOOL", "ADD(A,B,D);\nXIC(S:V)OTE(V);", ":D=-5536;V=1"),
        ("ADD of LINTs", "A LINT 4294967296, B DINT -1, D LINT, V BOOL", "ADD(A,B,D);\nXIC(S:V)OTE(V);", ":D=4294967295;V=0"),
        ("ADD of LINTs at their end", "A LINT 9223372036854775807, D LINT, V BOOL", "ADD(A,1,D);\nXIC(S:V)OTE(V);", ":D<0;V=1"),
        ("ADD of LREALs keeps their digits", "A LREAL 0.1, B LREAL 0.2, D LREAL, E REAL", "ADD(A,B,D);\nMOV(D,E);", ":A+B=D;D<>E;E>0.2999;E<0.3001"),
        ("ADD of REAL and DINT", "A REAL 0.5, B DINT 2, D REAL, E DINT", "ADD(A,B,D);\nADD(A,B,E);", ":D=2.5;E=2"),
        ("SUB of unsigned types", "A USINT 5, B USINT 7, D DINT, E USINT, V BOOL", "SUB(A,B,D);\nSUB(A,B,E);\nXIC(S:V)OTE(V);", ":D=-2;E=254;V=1"),
        ("numbers in hexadecimal have 32 bits", "N DINT -1, D DINT, V BOOL, E LINT, A BOOL, B BOOL", "MOV(16#FFFF_FFFF,D);\nXIC(S:V)OTE(V);\nMOV(16#0000_0000_FFFF_FFFF,E);\nEQU(N,16#FFFFFFFF)OTE(A);\nMEQ(N,16#F0000000,16#F0000000)OTE(B);", ":D=-1;V=0;E=4294967295;A=1;B=1"),
        ("MEQ and MVM with a mask of all bits", "N DINT -5, D DINT 7, A BOOL, B BOOL", "MEQ(N,-1,-5)OTE(A);\nMVM(N,-1,D);\nXIC(S:V)OTE(B);", ":A=1;D=-5;B=0"),
        ("bits do not overflow", "N DINT -2, D DINT, E DINT, V BOOL, Z BOOL, S BOOL", "AND(N,16#F0000001,D);\nXIC(S:V)OTE(V);\nXIC(S:N)OTE(S);\nNOT(N,E);", ":D=-268435456;V=0;S=1;E=1"),
        ("MVM of a LINT", "N LINT -1, D LINT", "MVM(N,-1,D);", ":D=-1"),
        ("AND of a SINT into DINT", "A SINT -1, D DINT", "AND(A,16#FFFF,D);", ":D=255"),
    ];
    run(rows);
}

/// A project with the type `S4`, a text of four characters.
fn with_short_text(tags: &str, rungs: &str) -> Project {
    let mut of = project(tags, &[("Main", rungs)]);
    let member = |name: &str, data_type: &str, dimensions: &[u32]| MemberSource {
        name: name.to_owned(),
        data_type: data_type.to_owned(),
        dimensions: dimensions.to_vec(),
        access: Access::ReadWrite,
    };
    of.types.push(TypeSource {
        name: "S4".to_owned(),
        is_string: true,
        members: vec![member("LEN", "DINT", &[]), member("DATA", "SINT", &[4])],
    });
    of
}

#[test]
fn texts_that_are_too_long_are_cut_with_a_minor_fault() {
    #[rustfmt::skip]
    let rows = [
        ("CONCAT(A,B,D);", "A STRING abc, B STRING def", "D.LEN=4;D.DATA[3]=100;V=1;M=1"),
        ("DTOS(-12345,D);", "", "D.LEN=4;V=1;M=1"),
        ("RTOS(0.125,D);", "", "D.LEN=4;V=1;M=1"),
        ("UPPER(A,D);", "A STRING abcde", "D.LEN=4;D.DATA[0]=65;V=1;M=1"),
        ("MOV(A,D);", "A STRING abcde", "D.LEN=4;V=1;M=1"),
        ("INSERT(A,B,1,D);", "A STRING abc, B STRING def", "D.LEN=4;D.DATA[0]=100;V=1;M=1"),
        ("DTOS(-123,D);", "", "D.LEN=4;V=0;M=0"),
    ];
    each(&rows, |(rung, tags, expected)| {
        let of = with_short_text(
            &format!("D S4, V BOOL, M BOOL, {tags}"),
            &format!("{rung}\nXIC(S:V)OTE(V);\nXIC(S:MINOR)OTE(M);"),
        );
        script(rung, &of, &format!(":{expected}"));
    });
}

#[test]
fn files_that_do_not_fit_are_faults() {
    #[rustfmt::skip]
    let cases = [
        ("XIC(I)FFL(V,A[0],C,?,?);", "C.LEN=5", (4, 20)),
        ("XIC(I)FFL(V,A[0],C,?,?);", "C.LEN=-1", (4, 20)),
        ("XIC(I)FFL(V,A[0],C,?,?);", "C.POS=-1", (4, 20)),
        ("XIC(I)FFU(A[0],V,C,?,?);", "C.POS=5", (4, 20)),
        ("XIC(I)LFL(V,A[0],C,?,?);", "C.LEN=5", (4, 20)),
        ("XIC(I)LFU(A[0],V,C,?,?);", "C.POS=-2", (4, 20)),
        ("XIC(I)SQL(A[0],V,C,?,?);", "C.LEN=9,C.POS=8", (4, 20)),
        ("XIC(I)SQO(A[0],-1,V,C,?,?);", "C.LEN=9,C.POS=8", (4, 20)),
        ("XIC(I)BSL(A[0],C,I,?);", "C.LEN=129", (4, 20)),
        ("XIC(I)BSR(A[0],C,I,?);", "C.LEN=-1", (4, 20)),
        ("XIC(I)AVE(A[0],0,V,C,?,?);", "C.LEN=9", (4, 20)),
        ("XIC(I)SRT(A[0],0,C,?,?);", "C.LEN=-1", (4, 21)),
        ("XIC(I)FAL(C,?,?,ALL,V,1);", "C.POS=-1", (4, 21)),
        ("XIC(I)FSC(C,?,?,ALL,V>1);", "C.LEN=0", (4, 21)),
    ];
    for (rung, sets, expected) in cases {
        let why = format!("{rung} {sets}");
        let of = project("I BOOL, V DINT, A DINT[4], C CONTROL 4", &[("Main", rung)]);
        let mut cell = started(&why, &of);
        let ran = cell.tick(0, 10_000_000, &mut NoMachine);
        ran.unwrap_or_else(|fault| panic!("{why}: a false rung: {fault}"));
        sets.split(',').for_each(|text| set(&why, &mut cell, &of, text));
        set(&why, &mut cell, &of, "I");
        let fault = cell.tick(1, 10_000_000, &mut NoMachine).expect_err(&why);
        assert_eq!((fault.kind, fault.code), expected, "{why}");
    }
}
