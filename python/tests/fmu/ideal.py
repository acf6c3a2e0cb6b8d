from pythonfmu3 import Fmi3Causality, Fmi3Slave, Fmi3Variability, Float64


class Ideal(Fmi3Slave):
    """An axis that is always at its set-point. A step behind the time `ends` fails."""

    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.time = self.r = self.rv = self.x = self.v = 0.0
        self.ends = 1e9
        self.register_variable(Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous))
        self.register_variable(Float64("ends", causality=Fmi3Causality.parameter, variability=Fmi3Variability.tunable))
        for name in ("r", "rv"):
            self.register_variable(Float64(name, causality=Fmi3Causality.input, variability=Fmi3Variability.continuous))
        for name in ("x", "v"):
            self.register_variable(Float64(name, causality=Fmi3Causality.output, variability=Fmi3Variability.continuous))

    def exit_initialization_mode(self):
        self.x, self.v = self.r, self.rv

    def do_step(self, now, step):
        self.x, self.v = self.r, self.rv
        return now < self.ends
