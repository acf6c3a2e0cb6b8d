// The messages between a page and the server. A test of the server writes this file from its types: run
// `UPDATE_EXPECT=1 cargo test -p arcline-server --lib hmi::protocol` after a change of them.

/** The fields and the answer of each request, by its `do`. */
export interface Requests {
  /** Tests the connection: the answer is empty. */
  ping: {
    fields: {};
    answer: Done;
  };
  /** Reports the input of a person. Without such reports the server locks the session after a time. */
  active: {
    fields: {};
    answer: Done;
  };
  /** Lists the sessions of the page: users who have logged in, and scripts that show a token. */
  sessions: {
    fields: {};
    answer: SessionList;
  };
  /** Ends a session, at once. A script may begin another one until its token is removed. */
  end_session: {
    fields: {
      /** Number of the session. */
      session: number;
    };
    answer: Done;
  };
  /** Takes control of a coordinate system and its axes, of one axis, or of the group. */
  take: {
    fields: {
      /** Takes control even if another viewer has it. */
      force?: boolean;
      /** Name of the coordinate system, axis or group. */
      object: string;
    };
    answer: Done;
  };
  /** Releases control of an object. */
  release: {
    fields: {
      /** Name of the object, as in `take`. */
      object: string;
    };
    answer: Done;
  };
  /** Executes one instruction. Stops need no control. */
  execute: {
    fields: {
      /** One call as Structured Text. */
      text: string;
    };
    answer: Executed;
  };
  /** Writes the values of a form as one line of Structured Text and checks it. */
  line: {
    fields: {
      /** Mnemonic. */
      instruction: string;
      /** Values by the member names of the operands; an omitted operand has its first value. */
      operands?: Record<string, unknown>;
    };
    answer: CallLine;
  };
  /** Jogs an axis until `jog_end`. The page must send `keep` at least every 150 ms. */
  jog: {
    fields: {
      /** Acceleration, position units/s²; default: the maximum of the axis. */
      accel?: number | null;
      /** Name of the axis. */
      axis: string;
      /** Deceleration, position units/s²; default: the maximum of the axis. */
      decel?: number | null;
      /** Speed with its sign, position units/s. */
      speed: number;
    };
    answer: Done;
  };
  /** Confirms a jog: the button is still pressed. */
  keep: {
    fields: {
      /** Name of the axis. */
      axis: string;
    };
    answer: Done;
  };
  /** Ends a jog: the button is released. */
  jog_end: {
    fields: {
      /** Name of the axis. */
      axis: string;
    };
    answer: Done;
  };
  /** Stops one object. Without an object it stops all motion and the program, and inhibits motion until `release_stop`. Needs no control. */
  stop: {
    fields: {
      /** Name of the coordinate system, axis or group. */
      object?: string | null;
    };
    answer: Done;
  };
  /** Releases the STOP of all motion: instructions can begin motion again. Needs no control. */
  release_stop: {
    fields: {};
    answer: Done;
  };
  /** Sets the feed override of a coordinate system. */
  override: {
    fields: {
      /** Name of the coordinate system. */
      coordinate_system: string;
      /** Percent of the programmed speeds. */
      percent: number;
    };
    answer: Done;
  };
  /** Sets the feed override to 0. Needs no control. */
  hold: {
    fields: {
      /** Name of the coordinate system. */
      coordinate_system: string;
    };
    answer: Done;
  };
  /** Restores the feed override from before the hold. */
  resume: {
    fields: {
      /** Name of the coordinate system. */
      coordinate_system: string;
    };
    answer: Done;
  };
  /** Simulates one instruction from the present state. The machine does not move. */
  preview: {
    fields: {
      /** One call as Structured Text. */
      text: string;
    };
    answer: Simulated;
  };
  /** Simulates a program from the present state. The machine does not move. */
  dry_run: {
    fields: {
      /** A program as Structured Text. */
      text: string;
    };
    answer: Simulated;
  };
  /** Checks a program. */
  check: {
    fields: {
      /** A program as Structured Text. */
      text: string;
    };
    answer: Checked;
  };
  /** Runs a program. The server runs one program at a time. */
  run: {
    fields: {
      /** Whether the program pauses before its first statement. */
      step?: boolean;
      /** A program as Structured Text. */
      text: string;
    };
    answer: Done;
  };
  /** Executes one statement of the program. */
  step: {
    fields: {};
    answer: Done;
  };
  /** Pauses the program before the next statement. */
  pause: {
    fields: {};
    answer: Done;
  };
  /** Continues the program. */
  continue: {
    fields: {};
    answer: Done;
  };
  /** Ends the program. Motion that it began continues. */
  end: {
    fields: {};
    answer: Done;
  };
  /** Lists tags, 200 at a time, in the order of their names. */
  tags: {
    fields: {
      /** The list begins after this name. */
      after?: string | null;
      /** Part of the name in any case, at most 100 bytes; `*` stands for any text, at most 8 times. */
      pattern?: string;
    };
    answer: TagPage;
  };
  /** Reads tags once. */
  read: {
    fields: {
      /** At most 200 names. */
      names: string[];
    };
    answer: Values;
  };
  /** Reads tags and watches them in place of those watched before: the push `values` has those that have changed, at most ten times a second. */
  watch: {
    fields: {
      /** At most 200 names. */
      names: string[];
    };
    answer: Values;
  };
  /** Writes a tag. */
  write: {
    fields: {
      /** Name of the tag, of its member or of one element. */
      tag: string;
      /** A number, boolean or text; a whole number beyond 2⁵³ as text. */
      value: unknown;
    };
    answer: Done;
  };
  /** Lists the tasks, programs and routines of the controller's own program. */
  routines: {
    fields: {};
    answer: RoutineList;
  };
  /** Reads the source of at most 100 rungs or lines of a routine. */
  rungs: {
    fields: {
      /** Number of rungs or lines. */
      count: number;
      /** Index of the first one, from 0. */
      from: number;
      /** Number of the routine. */
      routine: number;
    };
    answer: RoutinePage;
  };
  /** Watches at most 100 rungs or lines of a routine in place of those watched before: the push `look` has the power flow and values of those that have changed, at most five times a second. Without a routine the viewer watches none. */
  look: {
    fields: {
      /** Number of rungs or lines. */
      count?: number;
      /** Index of the first rung or line, from 0. */
      from?: number;
      /** Instance of the add-on instruction whose values are shown. */
      instance?: string | null;
      /** Number of the routine. */
      routine?: number | null;
      /** Version of the program to which the numbers belong. */
      version?: number;
    };
    answer: Done;
  };
  /** Lists the uses of a tag of the controller's own program, of its parts, and of the tags that it is a part of. */
  uses: {
    fields: {
      /** Program whose scope has the tag; default: the scope of the controller. */
      program?: string | null;
      /** Name of the tag or of its part. */
      tag: string;
    };
    answer: UseList;
  };
  /** Starts the controller's own program (Run mode), or stops it and all motion (Program mode). */
  mode: {
    fields: {
      /** `true` starts the program, `false` stops it. */
      run: boolean;
    };
    answer: Done;
  };
  /** Forces an input of a module: the controller's own program reads the forced value. */
  force: {
    fields: {
      /** Name of the input, such as `Local:1:I.Data.0`. */
      tag: string;
      /** A number or boolean; null removes the force. */
      value: unknown;
    };
    answer: Done;
  };
  /** Removes all forces. */
  remove_forces: {
    fields: {};
    answer: Done;
  };
  /** Starts or ends the binary frames of samples. */
  trace: {
    fields: {
      /** `true` starts the frames, `false` ends them. */
      on: boolean;
    };
    answer: Signals;
  };
  /** Requests the newest samples before a tick. The server sends a binary frame, then the answer. At most two frames of a viewer may wait. */
  history: {
    fields: {
      /** The tick. */
      before: number;
    };
    answer: HistoryPiece;
  };
  /** Lists the newest 1,000 events. */
  events: {
    fields: {
      /** The list begins after this `seq`. */
      since?: number | null;
    };
    answer: EventPage;
  };
}

/** A message of the server that no request asked for, by its `push`. */
export type Push =
  | {
      push: "hello";
      /** Names of the signals of frames of samples, in the order of a row. */
      trace_signals: string[];
      /** The name of this viewer, as in `drivers`. */
      viewer: string;
    }
  | {
      /** Whether a user can log in on this connection. */
      can_log_in: boolean;
      /** Whether the session is locked: until the user logs in again, this viewer can only view and stop. */
      locked: boolean;
      push: "session";
      /** The role that this viewer has now: `viewer`, `operator`, `engineer` or `administrator`. */
      role: string;
      /** The user who has logged in; null without one. */
      user: string | null;
    }
  | Status & {
      push: "status";
    }
  | {
      /** Oldest first. */
      events: Event[];
      push: "event";
    }
  | {
      push: "values";
      /** The value of each name that has changed, or `{error}`. */
      values: Record<string, unknown>;
    }
  | ProgramStatus & {
      push: "program";
    }
  | {
      push: "look";
      /** Number of the routine. */
      routine: number;
      /** The rungs or lines that have changed. */
      rows: MonitorRow[];
    };

/** The active move of a coordinate system. */
export type ActiveMove = {
  /** Time to go, s; null while it is not known. */
  eta_s: number | null;
  /** Mnemonic. */
  instruction: string;
  /** Completed share of its path, 0 to 1. */
  progress: number;
  /** Distance to go, position units. */
  remaining: number;
  /** Name of its motion control tag; empty without one. */
  tag: string;
};

/** An add-on instruction. */
export type AddOnRow = {
  /** Its instances among the tags, at most 200. */
  instances: string[];
  /** Name. */
  name: string;
  /** Its routines. */
  routines: RoutineRow[];
};

/** An axis as configured. Rates are in its position units per s, s² and s³. */
export type AxisConfiguration = {
  /** Maximum Acceleration. */
  max_acceleration: number;
  /** Maximum Acceleration Jerk. */
  max_acceleration_jerk: number;
  /** Maximum Deceleration. */
  max_deceleration: number;
  /** Maximum Deceleration Jerk. */
  max_deceleration_jerk: number;
  /** Maximum Speed. */
  max_speed: number;
  /** Name. */
  name: string;
  /** Whether the axis is rotary. */
  rotary: boolean;
  /** Soft travel limits. */
  travel: TravelLimits | null;
  /** Kind of drive. */
  type: AxisType;
  /** Position units. */
  units: string;
  /** Unwind, position units. */
  unwind: number | null;
};

/** The greatest magnitudes of an axis in a simulation. */
export type AxisPeaks = {
  /** Position units/s². */
  acceleration: number;
  /** Name of the axis. */
  axis: string;
  /** Position units/s³. */
  jerk: number;
  /** Position units/s. */
  velocity: number;
};

/** The state of an axis, in its position units. */
export type AxisStatus = {
  /** Command acceleration, position units/s². */
  acceleration: number;
  /** Actual position. */
  actual: number;
  /** Actual velocity, position units/s. */
  actual_velocity: number;
  /** Names of the status bits that are set, without those of faults and alarms. */
  bits: string[];
  /** Command position. */
  command: number;
  /** Following error. */
  error: number;
  /** Words of the faults that are set. */
  faults: string[];
  /** Whether the axis is homed. */
  homed: boolean;
  /** The client, page or program that moves it, or moves its coordinate system; null while nothing does. */
  moved_by: string | null;
  /** Whether the command velocity is not 0. */
  moving: boolean;
  /** Name. */
  name: string;
  /** Whether the servo is on. */
  servo_on: boolean;
  /** CIPAxisState in words. */
  state: string;
  /** Command velocity, position units/s. */
  velocity: number;
};

/** Kind of an axis's drive. */
export type AxisType = "virtual" | "servo";

/** The line of a form. */
export type CallLine = {
  /** One call as Structured Text. */
  text: string;
};

/** Every instruction, error and fault. */
export type Catalogue = {
  /** Every motion error. */
  errors: ErrorMeaning[];
  /** Every fault of an axis. */
  faults: FaultMeaning[];
  /** Every instruction. */
  instructions: InstructionForm[];
};

/** The errors of a program. */
export type Checked = {
  /** The errors with their lines and columns; empty for a correct program. */
  errors: Refusal[];
};

/** A tolerance about a point. */
export type Circle = {
  /** The point, in position units. */
  centre: number[];
  /** The tolerance, in position units. */
  radius: number;
};

/** A greatest value that holds under a condition. */
export type ConditionalMaximum = {
  /** Its values. */
  in: number[];
  /** Greatest value. */
  max: number;
  /** Member of the operand. */
  member: string | null;
};

/** A major fault. */
export type ControllerFault = {
  /** Mnemonic; empty for a statement. */
  instruction: string;
  /** Number of the rung or line in the file. */
  line: number;
  /** The operand at fault. */
  operand: string | null;
  /** Number of the routine. */
  routine: number | null;
  /** A description, as a sentence. */
  text: string;
  /** Value of that operand. */
  value: number | null;
};

/** State of the controller's own program. */
export type ControllerState = "stopped" | "running" | "faulted";

/** The controller's own program. */
export type ControllerStatus = {
  /** The major fault that has stopped the tasks. */
  fault: ControllerFault | null;
  /** Forced inputs. */
  forces: ForceRow[];
  /** Duration of the newest scan, µs. */
  last_us: number;
  /** Duration of the longest scan, µs. */
  longest_us: number;
  /** Requested mode: `program` or `run`. */
  mode: string;
  /** Number of ticks in which due tasks were scanned. */
  scans: number;
  /** State of the program. */
  state: ControllerState;
  /** A number that changes with each loaded program. */
  version: number;
};

/** Planning of corners. */
export type CornerPlanning = "logix" | "precise";

/** A target position dialog. */
export type DialogForm = {
  /** Member of the circle type. */
  circle_type: string | null;
  /** Member of the move type. */
  move_type: string;
  /** Its headings for each combination of move type and circle type. */
  rows: DialogRow[];
  /** Member of the end points. */
  targets: string;
  /** Member of the vias. */
  vias: string | null;
};

/** The headings of a target position dialog for a move type and circle type. */
export type DialogRow = {
  /** Value of Circle Type. */
  circle_type: number | null;
  /** Value of Move Type. */
  move_type: number;
  /** Heading of the end points. */
  target: string;
  /** Whether the dialog offers "Set Targets = Actuals". */
  targets_from_actuals: boolean;
  /** Heading of the vias, centres or the radius. */
  via: string | null;
  /** Whether the dialog offers "Set Vias = Actuals". */
  vias_from_actuals: boolean;
};

/** The server has carried out the request. */
export type Done = {};

/** The number of elements of an array. */
export type Elements = "per_axis" | {
  at_least: number;
};

/** The cause that ended an instruction or cleared a fault. */
export type EndCause = {
  /** A description, as a sentence. */
  text: string;
} & ({
  by: "instruction";
  /** Mnemonic. */
  instruction: string;
  /** Number of its execution. */
  ticket: number;
} | {
  /** Name of the axis. */
  axis: string | null;
  by: "fault";
  /** Words of the faults. */
  faults: string[];
} | {
  by: "stop";
} | {
  by: "dead-man";
  /** Reason for the end. */
  reason: string;
});

/** A motion error. */
export type ErrorMeaning = {
  /** Its usual cause. */
  cause: string;
  /** ERR. */
  err: number;
  /** Meaning of EXERR. */
  extended: string;
  /** Name. */
  name: string;
  /** Its remedy. */
  remedy: string;
};

/** A change of an instruction or of an axis's faults. */
export type Event = {
  /** Time of the day, ms since 1970-01-01 UTC. */
  at_ms: number;
  /** Number of the event, ascending. */
  seq: number;
  /** Tick. */
  tick: number;
  /** Machine time of the tick, s. */
  time_s: number;
} & (InstructionEvent | {
  /** The change of the faults. */
  fault: FaultEvent;
} | {
  /** The rest. */
  rest: RestEvent;
});

/** Events of instructions and faults. */
export type EventPage = {
  /** Oldest first. */
  events: Event[];
};

/** An instruction that was accepted. */
export type Executed = {
  /** Instance of class 0x0303. */
  instance: number;
  /** Mnemonic. */
  instruction: string;
};

/** A change of an axis's faults. */
export type FaultEvent = {
  /** Words of the faults that were reset and set again at once, since their cause persists. */
  again: string[];
  /** Name of the axis. */
  axis: string | null;
  /** The cause that cleared the faults. */
  by: EndCause | null;
  /** Words of the faults that were cleared. */
  clear: string[];
  /** The command that the axis refused. */
  refused: RefusedCommand | null;
  /** Words of the faults that were set. */
  set: string[];
};

/** A fault of an axis. */
export type FaultMeaning = {
  /** Its cause. */
  meaning: string;
  /** Its word in `faults` of an axis. */
  word: string;
};

/** The first value of an operand. */
export type FirstValue = number | [];

/** A forced input. */
export type ForceRow = {
  /** Name of the input. */
  tag: string;
  /** The value that the program reads. */
  value: unknown;
};

/** The state of the group. */
export type GroupStatus = {
  /** Names of the status bits that are set. */
  bits: string[];
  /** Name. */
  name: string;
};

/** The contents of the binary frame before this answer. */
export type HistoryPiece = {
  /** Number of ticks that a row covers. */
  every: number;
  /** Tick of its first row. */
  first: number;
  /** Number of rows; 0 if the server has no older samples. */
  rows: number;
};

/** A change of an instruction's status bits. */
export type InstructionEvent = {
  /** Bits that were cleared. */
  clear: string[];
  /** The cause that ended the instruction prematurely. */
  ended: EndCause | null;
  /** ERR. */
  err: number;
  /** The error, if ER was set. */
  error: Refusal | null;
  /** EXERR. */
  exerr: number;
  /** Mnemonic. */
  instruction: string;
  /** The axis, coordinate system or group on which the instruction acts. */
  object: string | null;
  /** Bits that were set. */
  set: string[];
  /** Name of its motion control tag; empty without one. */
  tag: string;
  /** Its line of Structured Text, if a page executed it. */
  text: string | null;
  /** Number of the execution. */
  ticket: number;
  /** The viewer that executed it. */
  viewer: string | null;
};

/** An instruction and its form. */
export type InstructionForm = {
  /** Mnemonic. */
  mnemonic: string;
  /** Kind of its object: `Axis`, `CoordinateSystem` or `MotionGroup`. */
  object: string;
  /** Its operands in the order of the faceplate. */
  operands: OperandForm[];
  /** A description, as a sentence. */
  summary: string;
  /** Its target position dialog. */
  target_position: DialogForm | null;
  /** Full name. */
  title: string;
};

/** A limit that a simulation would exceed. */
export type LimitText = {
  /** A description, as a sentence. */
  text: string;
};

/** The machine as configured. */
export type Machine = {
  /** Every axis. */
  axes: AxisConfiguration[];
  /** Every coordinate system. */
  coordinate_systems: SystemConfiguration[];
  /** Name of the motion group. */
  group: string;
  /** The notice beside the log-in; null without one. */
  login_notice: string | null;
  /** Name of the server. */
  name: string;
  /** Coarse update period, s. */
  period_s: number;
  /** Version of the server. */
  version: string;
};

/** The state of a rung or line. */
export type MonitorRow = {
  /** Index in the routine, from 0. */
  index: number;
  /** One digit, `0` or `1`, for the rung condition and for the condition after each element. Empty: the last scan of the program did not include the rung. */
  power: string;
  /** Value of each operand, or of each tag of a line; null: there is none. Whole numbers beyond 2⁵³ are text. */
  values: unknown[];
};

/** The condition that an operand has one of these values. */
export type OperandCondition = {
  /** Its values. */
  in: number[];
  /** Member of the operand. */
  member: string | null;
};

/** An operand of a form. */
export type OperandForm = {
  /** First value. */
  default: FirstValue;
  /** Elements of an array. */
  elements?: Elements | null;
  /** A note. */
  help: string;
  /** Kind. */
  kind: OperandKind;
  /** Member of an instruction tag, and key in `operands` of `line`. */
  member: string;
  /** Name on the faceplate. */
  name: string;
  /** Kind of the object that it names. */
  object?: string | null;
  /** Range of a number; null or absent: every finite number. */
  range?: RangeForm | null;
  /** Conditions under which the operand has an effect; null: always. */
  shown_when: OperandCondition[] | null;
  /** Condition under which one element is enough. */
  single_when?: OperandCondition | null;
  /** Type of the structure that it names. */
  type?: string | null;
  /** Unit of its numbers. */
  unit: UnitForm | null;
  /** Words of an enumeration. */
  words?: WordForm[] | null;
};

/** Kind of an operand. */
export type OperandKind = "target" | "control" | "reference" | "word" | "number" | "integer" | "array" | "array_or_none" | "written_array" | "structure" | "structure_or_none";

/** A part of the project that does not run. */
export type PassedOver = {
  /** Number of its rung or line in the file. */
  number: number | null;
  /** Its position, in words; empty: the project as a whole. */
  place: string;
  /** Number of its routine. */
  routine: number | null;
  /** The part and the reason. */
  text: string;
};

/** Programmed paths as points, in position units. */
export type Paths = {
  /** The path of the active move; empty without one. */
  active: number[][];
  /** The paths of pending moves. */
  pending: number[][][];
  /** The tolerance at the end of each blended move. */
  tolerance: Circle[];
};

/** A move that waits in the queue. */
export type PendingMove = {
  /** Mnemonic. */
  instruction: string;
  /** Name of its motion control tag; empty without one. */
  tag: string;
};

/** A program of the controller. */
export type ProgramRow = {
  /** Whether the task skips the program. */
  disabled: boolean;
  /** Name of the routine that runs after a major fault. */
  fault: string | null;
  /** Name of the routine that its task runs. */
  main: string | null;
  /** Name. */
  name: string;
  /** Its routines. */
  routines: RoutineRow[];
};

/** State of a program. */
export type ProgramState = "idle" | "running" | "paused" | "ended" | "failed";

/** The program that runs, or ran last. */
export type ProgramStatus = {
  /** Error of a failed program. */
  error: Refusal | null;
  /** Line of the statement that runs or comes next, from 1. */
  line: number | null;
  /** A number that changes with each program. */
  run: number;
  /** State. */
  state: ProgramState;
  /** Its text; only with a new `run`. */
  text?: string | null;
  /** The viewer that began it. */
  viewer: string | null;
};

/** A range of numbers. */
export type RangeForm = {
  /** Greatest value; null: none. */
  max: number | null;
  /** A greatest value that holds under a condition. */
  max_when?: ConditionalMaximum | null;
  /** Least value. */
  min: number;
  /** Whether the least value itself is outside of the range. */
  min_exclusive?: boolean;
};

/** Measurements of the real-time thread. */
export type RealTime = {
  /** Computing time of a tick: maximum, µs. */
  compute_max_us: number;
  /** Computing time of a tick: 99th percentile, µs. */
  compute_p99_us: number;
  /** Whether the thread has real-time priority. */
  fifo: boolean;
  /** Tick lateness: maximum, µs. */
  max_us: number;
  /** Whether the thread's memory is locked. */
  memory_locked: boolean;
  /** Missed ticks. */
  missed: number;
  /** Tick lateness: median, µs. */
  p50_us: number;
  /** Tick lateness: 99th percentile, µs. */
  p99_us: number;
};

/** The reason for which the server refuses a request, or the error of an instruction. */
export type Refusal = {
  /** The usual cause of ERR, as `arcline explain` prints it. */
  cause?: string | null;
  /** Column of the text, from 1. */
  column?: number | null;
  /** The operand, axis or detail that EXERR identifies. */
  concerns?: string | null;
  /** The object whose control the request needs. */
  control?: string;
  /** ERR of a motion instruction. */
  err?: number | null;
  /** EXERR of a motion instruction. */
  exerr?: number | null;
  /** The viewer that has control of that object. */
  holder?: string | null;
  /** Line of the text, from 1. */
  line?: number | null;
  /** The member of the operand at fault. */
  member?: string | null;
  /** The remedy for ERR. */
  remedy?: string | null;
  /** The reason, as a sentence. */
  text: string;
};

/** A command position that an axis refused. */
export type RefusedCommand = {
  /** Position and velocity of the refused command; null for a value that is not a number. */
  asked: [number, number];
  /** The instruction that commanded it. */
  by: EndCause | null;
  /** Position and velocity of the last command, position units and position units/s. */
  last: [number, number];
  /** A description, as a sentence. */
  text: string;
};

/** The rest of a planned contour between moves that go on. */
export type RestEvent = {
  /** Number of rests of that cause since the start. */
  count: number;
  /** The part that was too slow: `program`, whose next move came late, or `planner`. */
  slow: SlowPart;
  /** The coordinate system. */
  system: string | null;
  /** A description, as a sentence. */
  text: string;
};

/** The controller's own program. */
export type RoutineList = {
  /** Its add-on instructions. */
  add_ons: AddOnRow[];
  /** Name of its file. */
  file: string;
  /** Its parts that do not run and are passed over, at most 200. */
  passed_over: PassedOver[];
  /** The number of all of them. */
  passed_over_count: number;
  /** Its programs. */
  programs: ProgramRow[];
  /** Its tasks. */
  tasks: TaskRow[];
  /** A number that changes with each loaded program. */
  version: number;
};

/** Rungs or lines of a routine. */
export type RoutinePage = {
  /** The lines of a routine of Structured Text. */
  lines: TextLine[];
  /** The rungs of a ladder routine. */
  rungs: Rung[];
  /** Version of the program. */
  version: number;
};

/** A routine. */
export type RoutineRow = {
  /** Number of rungs or lines. */
  count: number;
  /** `ladder` or `text`; a routine of another language does not run. */
  language: string;
  /** Name. */
  name: string;
  /** Number of the routine, as in the requests. */
  routine: number;
};

/** A rung. */
export type Rung = {
  /** Comment; empty without one. */
  comment: string;
  /** Elements from left to right. */
  elements: RungElement[];
  /** Number in the file. */
  number: number;
};

/** An element of a rung: an instruction, or a branch with legs. */
export type RungElement = {
  /** Index of its condition in `power` of the push `look`. */
  condition: number;
  /** Legs of a branch, from top to bottom. */
  legs?: RungElement[][];
  /** Mnemonic; empty for a branch. */
  name?: string;
  /** Operands, in the order of the values of the push `look`. */
  operands?: RungOperand[];
  /** Name of the instruction in words. */
  title?: string;
};

/** An operand. */
export type RungOperand = {
  /** Name of the operand. */
  name: string;
  /** Its text in the project. */
  text: string;
};

/** The sessions of the page. */
export type SessionList = {
  /** In the order in which they began. */
  sessions: SessionRow[];
};

/** A session of the page. */
export type SessionRow = {
  /** Address from which it began. */
  address: string;
  /** Time since it began, s. */
  age_s: number;
  /** Time since the newest input of a person, s. */
  idle_s: number;
  /** Whether it is locked: its pages look and stop. */
  locked: boolean;
  /** Whether it is the session of the viewer that asks. */
  own: boolean;
  /** Number of open pages. */
  pages: number;
  /** Role of its user or token. */
  role: string;
  /** Whether it is the session of a script. */
  script: boolean;
  /** Its number since the start of the server. */
  session: number;
  /** Name of its user, or of the token of its script. */
  user: string;
};

/** The signals of the frames of samples. */
export type Signals = {
  /** Time of a tick, s. */
  period_s: number;
  /** Names of the signals, in the order of a row. */
  signals: string[];
};

/** The result of a preview or a dry run. */
export type Simulated = {
  /** Simulated time, s; null if the motion has no end. */
  duration_s: number | null;
  /** The events of the instructions, at most 1,000. */
  events: SimulatedEvent[];
  /** The first limit that would be exceeded. */
  limit: LimitText | null;
  /** The path of each coordinate system that moved. */
  paths: SimulatedPath[];
  /** The peaks of each axis. */
  peaks: AxisPeaks[];
  /** Simulated ticks. */
  ticks: number;
  /** The first soft travel limit that would be exceeded. */
  travel: LimitText | null;
};

/** A change of an instruction's status bits in a simulation. */
export type SimulatedEvent = {
  /** Bits that were cleared. */
  clear: string[];
  /** ERR. */
  err: number;
  /** The error, if ER was set. */
  error: Refusal | null;
  /** EXERR. */
  exerr: number;
  /** Mnemonic. */
  instruction: string;
  /** Bits that were set. */
  set: string[];
  /** Name of the motion control tag; empty without one. */
  tag: string;
  /** Simulated tick. */
  tick: number;
  /** Simulated time, s. */
  time_s: number;
};

/** The path of a coordinate system in a simulation. */
export type SimulatedPath = {
  /** The tolerance about the end of each blended move. */
  blends: Circle[];
  /** Name of the coordinate system. */
  coordinate_system: string;
  /** Positions of its axes, or of the tool of a robot, in position units. */
  points: number[][];
};

/** The part that was too slow. */
export type SlowPart = "program" | "planner";

/** The state of the machine. */
export type Status = {
  /** Number of events that the audit has lost since the start; null without an audit. */
  audit_lost: number | null;
  /** Every axis, in the order of the configuration. */
  axes: AxisStatus[];
  /** The controller's own program; null without one. */
  controller: ControllerStatus | null;
  /** Every coordinate system, in the order of the configuration. */
  coordinate_systems: SystemStatus[];
  /** The viewer that has control of an object, by the object's name. */
  drivers: Record<string, string>;
  /** The group. */
  group: GroupStatus;
  /** Whether STOP inhibits motion until it is released. */
  inhibited: boolean;
  /** The real-time thread. */
  realtime: RealTime;
  /** Tick since the start of the server. */
  tick: number;
  /** Machine time of the tick, s. */
  time_s: number;
};

/** A coordinate system as configured. Rates are in position units per s, s² and s³. */
export type SystemConfiguration = {
  /** Actual tolerance, position units. */
  actual_tolerance: number;
  /** Names of its axes. */
  axes: string[];
  /** Command tolerance, position units. */
  command_tolerance: number;
  /** Planning of corners. */
  corner: CornerPlanning;
  /** Maximum Acceleration. */
  max_acceleration: number;
  /** Maximum Acceleration Jerk. */
  max_acceleration_jerk: number;
  /** Maximum Deceleration. */
  max_deceleration: number;
  /** Maximum Deceleration Jerk. */
  max_deceleration_jerk: number;
  /** Maximum Speed. */
  max_speed: number;
  /** Name. */
  name: string;
  /** Number of moves for which its queue has room. */
  queue_depth: number;
  /** Whether the coordinate system is a robot: frames of samples have the position of its tool. */
  robot: boolean;
};

/** The state of a coordinate system. */
export type SystemStatus = {
  /** The active move. */
  active: ActiveMove | null;
  /** Names of the status bits that are set. */
  bits: string[];
  /** Whether a feed hold is in force. */
  held: boolean;
  /** The client, page or program that moves it; null while nothing does. */
  moved_by: string | null;
  /** Name. */
  name: string;
  /** Feed override, percent. */
  override: number;
  /** The programmed paths; only when `path_version` has changed, and never for a robot. */
  path?: Paths | null;
  /** A number that changes with the paths. */
  path_version: number;
  /** Pending moves, oldest first, at most 200. */
  pending: PendingMove[];
  /** Actual positions of its axes. */
  position: number[];
  /** Path speed, position units/s. */
  speed: number;
};

/** The access of clients to a tag. */
export type TagAccess = "read" | "read/write";

/** Tags by their names. */
export type TagPage = {
  /** Whether more tags follow. */
  more: boolean;
  /** At most 200 tags. */
  tags: TagRow[];
};

/** A tag of a list. */
export type TagRow = {
  /** The access of clients to the tag. */
  access: TagAccess;
  /** Sizes of an array; empty for a single value. */
  dims: number[];
  /** Name, with `Program:NAME.` in front of a tag of a program. */
  name: string;
  /** Name of the data type. */
  type: string;
  /** Value, if the tag is a single value of an elementary type. */
  value?: unknown;
};

/** A task. */
export type TaskRow = {
  /** Whether the task is inhibited. */
  inhibited: boolean;
  /** Name. */
  name: string;
  /** Priority: 1, the highest, to 15. */
  priority: number;
  /** Names of its programs, in their order. */
  programs: string[];
  /** Description of its trigger. */
  trigger: string;
  /** Watchdog time, ms. */
  watchdog_ms: number;
};

/** A line of Structured Text. */
export type TextLine = {
  /** Tags of the line, in the order of the values of the push `look`. */
  names: string[];
  /** Number in the file. */
  number: number;
  /** The line. */
  text: string;
};

/** Soft travel limits, position units. */
export type TravelLimits = {
  /** Positive limit. */
  max: number;
  /** Negative limit. */
  min: number;
};

/** The unit of an operand. */
export type UnitForm = {
  /** Member of that operand. */
  member: string | null;
} | {
  /** The unit; `position` stands for position units. */
  text: string;
};

/** The uses of a tag. */
export type UseList = {
  /** Whether there are more uses. */
  more: boolean;
  /** Full name of the tag, with its aliases resolved. */
  tag: string;
  /** The uses, at most 500. */
  uses: UseRow[];
};

/** A use of a tag. */
export type UseRow = {
  /** Index of the rung or line in the routine, from 0. */
  index: number;
  /** Mnemonic; empty for a statement of Structured Text. */
  instruction: string;
  /** Description of the rung or line. */
  line: string;
  /** The text of the tag in the operand. */
  operand: string;
  /** Number of the routine. */
  routine: number;
  /** Whether the instruction writes the tag. */
  writes: boolean;
};

/** Values of tags. */
export type Values = {
  /** Names of the read-only tags among them. */
  read_only: string[];
  /** The value of each name, or `{error}`. Whole numbers beyond 2⁵³ are text. */
  values: Record<string, unknown>;
};

/** A word of an enumeration. */
export type WordForm = {
  /** The word in Structured Text. */
  text: string;
  /** The word on a faceplate. */
  title: string;
  /** Its number. */
  value: number;
};
