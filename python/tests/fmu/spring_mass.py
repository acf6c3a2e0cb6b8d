import math
from pythonfmu3 import Fmi3Causality, Fmi3Slave, Fmi3Variability, Float64


class SpringMass(Fmi3Slave):
    """A mass that a spring ties to its command."""

    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.time = self.hertz = self.r = self.rv = self.x = self.v = 0.0
        self.hertz = 27.0
        self.behind = self.rate = self.last = 0.0
        self.register_variable(Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous))
        self.register_variable(Float64("hertz", causality=Fmi3Causality.parameter, variability=Fmi3Variability.tunable))
        for name in ("r", "rv"):
            self.register_variable(Float64(name, causality=Fmi3Causality.input, variability=Fmi3Variability.continuous))
        for name in ("x", "v"):
            self.register_variable(Float64(name, causality=Fmi3Causality.output, variability=Fmi3Variability.continuous))

    def exit_initialization_mode(self):
        self.x, self.v, self.last = self.r, self.rv, self.rv

    def do_step(self, now, step):
        omega = 2 * math.pi * self.hertz
        acceleration = (self.rv - self.last) / step
        rest = -acceleration / omega**2
        cos, sin = math.cos(omega * step), math.sin(omega * step)
        away = self.behind - rest
        self.behind = rest + away * cos + self.rate / omega * sin
        self.rate = self.rate * cos - away * omega * sin
        self.last = self.rv
        self.x, self.v = self.r + self.behind, self.rv + self.rate
        return True
