"""The curves of De Groote, Kinney, Rao and Fregly, smooth everywhere, with OpenSim's coefficients.

De Groote et al., Evaluation of direct collocation optimal control problem formulations for solving the muscle
redundancy problem, Annals of Biomedical Engineering 44, 2016; coefficients as in OpenSim 4.6, DeGrooteFregly2016Muscle.
"""

from __future__ import annotations

import casadi as ca

from ..block import Symbols
from ..dialect import clamp
from .normalised import fibre_numbers, normalised, tendon_numbers

_SOURCE = "OpenSim 4.6, DeGrooteFregly2016Muscle"

# tendon force: c₁, c₂, c₃
_C1, _C2, _C3 = 0.2, 1.0, 0.2
# force-length factor: b₁, b₂, b₃, b₄ of three bells
_BELLS = (
    (0.8150671134243542, 1.055033428970575, 0.162384573599574, 0.063303448465465),
    (0.433004984392647, 0.71677541339776, -0.029947116970696, 0.200356847296188),
    (0.1, 1.0, 0.353553390593274, 0.0),
)
# passive force: shape, and the fibre length without force
_K_PE, _L_MIN = 4.0, 0.2
# force-velocity factor: d₁ … d₄
_D1, _D2, _D3, _D4 = -0.3211346127989808, -8.149, -0.374, 0.8825327733249912

# the tendon pushes with less than c₃ however short it is; the inverse goes this far
_PUSHED = 0.99 * _C3
# a bell's width is 0 at one length, where the bell is 0 as well
_NARROWEST = 1e-6
# from the undamped velocity, for damping up to 10 and force factors up to 2
_NEWTON_STEPS = 8


def _kT(p: Symbols) -> ca.SX:
    # fT(1 + strain) = 1
    return ca.log((1 + _C3) / _C1) / (p.tendon_strain + 1 - _C2)


def _fT(lT: ca.SX, p: Symbols) -> ca.SX:
    # fT = c₁ exp(kT(lT − c₂)) − c₃
    return _C1 * ca.exp(_kT(p) * (lT - _C2)) - _C3


def _fT_inv(force: ca.SX, p: Symbols) -> ca.SX:
    # lT = log((fT + c₃)/c₁)/kT + c₂
    return ca.log((ca.fmax(force, -_PUSHED) + _C3) / _C1) / _kT(p) + _C2


def _fP(length: ca.SX, p: Symbols) -> ca.SX:
    # fP = (exp(kPE(l − 1)/e₀) − exp(kPE(l_min − 1)/e₀))/(exp(kPE) − exp(kPE(l_min − 1)/e₀))
    shift = ca.exp(_K_PE * (_L_MIN - 1) / p.passive_strain)
    return (ca.exp(_K_PE * (length - 1) / p.passive_strain) - shift) / (ca.exp(_K_PE) - shift)


def _fL(length: ca.SX, p: Symbols) -> ca.SX:
    # fL = Σ b₁ exp(−½((l − b₂)/(b₃ + b₄ l))²)
    total = ca.SX(0)
    for height, centre, width, growth in _BELLS:
        square = ca.fmax((width + growth * length) ** 2, _NARROWEST**2)
        total += height * ca.exp(-0.5 * (length - centre) ** 2 / square)
    return total


def _fV(v: ca.SX, p: Symbols) -> ca.SX:
    # fV = d₁ log(d₂v + d₃ + √((d₂v + d₃)² + 1)) + d₄
    return _D1 * ca.asinh(_D2 * v + _D3) + _D4


def _fV_inv(factor: ca.SX, beta: ca.SX | float, p: Symbols) -> ca.SX:
    # undamped: v = (sinh((fV − d₄)/d₁) − d₃)/d₂
    free = (factor - _D4) / _D1
    # y = asinh(d₂v + d₃) lies between that of the undamped fibre and that of one at rest
    rest = ca.asinh(ca.SX(_D3))
    y, low, high = free, ca.fmin(free, rest), ca.fmax(free, rest)
    for _ in range(_NEWTON_STEPS if isinstance(beta, ca.SX) else 0):
        # d₁y + d₄ + β(sinh y − d₃)/d₂ = factor   Newton
        residual = _D1 * (y - free) + beta * (ca.sinh(y) - _D3) / _D2
        y = clamp(y - residual / (_D1 + beta * ca.cosh(y) / _D2), low, high)
    return (ca.sinh(y) - _D3) / _D2


DEGROOTE_FREGLY2016 = normalised(
    name="degroote_fregly2016",
    sentence="smooth curves in closed form; the tendon pushes below its slack length, passive force at every length",
    source="De Groote et al., Annals of Biomedical Engineering 2016; coefficients of OpenSim 4.6",
    tendon=tendon_numbers(0.049, _SOURCE),
    fibre=fibre_numbers(0.6, _SOURCE),
    fT=_fT,
    fT_inv=_fT_inv,
    fP=_fP,
    fL=_fL,
    fV=_fV,
    fV_inv=_fV_inv,
    toe_force=1.0,  # it is straight nowhere; its strain is that at this force
)
