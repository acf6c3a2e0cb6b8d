//! A program on a terminal of its own, 160 by 40: the test waits for texts of the program and then types keys.

use std::process::{Command, Stdio};

use crate::command_line::Outcome;

/// Needs Python 3.9. Arguments: the talk as JSON, then the program.
const TALK: &str = r"
import fcntl, json, os, pty, select, struct, sys, termios, time
talk = json.loads(sys.argv[1])
child, terminal = pty.fork()
if child == 0:
    fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack('HHHH', 40, 160, 0, 0))
    os.environ['TERM'] = 'xterm-256color'
    os.execv(sys.argv[2], sys.argv[2:])
seen, mark, end = b'', 0, time.monotonic() + 60
while True:
    while talk and talk[0][0].encode() in seen[mark:]:
        awaited, keys = talk.pop(0)
        mark = seen.index(awaited.encode(), mark) + len(awaited.encode())
        os.write(terminal, keys.encode())
    if not select.select([terminal], [], [], max(0, end - time.monotonic()))[0]:
        os.kill(child, 9)
        sys.stderr.write(f'no end, waiting for {talk[:1]}')
        break
    try:
        data = os.read(terminal, 65536)
    except OSError:
        data = b''
    if not data:
        break
    seen += data
sys.stdout.buffer.write(seen)
sys.stdout.flush()
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
";

/// Runs `shown` to its end; `talk` has the texts to wait for and the keys to type then. The output is in `stdout`.
///
/// # Panics
/// When there is no `python3`.
#[must_use]
pub fn at_a_terminal(shown: &Command, talk: &[(&str, &str)]) -> Outcome {
    let talk = serde_json::to_string(talk).expect("texts are JSON");
    let output = Command::new("python3")
        .args(["-c", TALK, &talk])
        .arg(shown.get_program())
        .args(shown.get_args())
        .stdin(Stdio::null())
        .output()
        .expect("python3 can be started");
    Outcome {
        code: output.status.code(),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}
