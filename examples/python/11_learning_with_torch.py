"""A payload and the friction of the joints, learned together from measured torques, with PyTorch."""

# %% [markdown]
# The measured arm is that of the drawing with an unknown payload, and with friction in its joints for which
# the library has no formula. Torques have noise of 0.1 N m.

# %%
import axode
import axode.torch
import numpy as np
import torch  # type: ignore[import-not-found, unused-ignore]

drawn = axode.load(axode.robots / "arm7.toml")
tool = axode.lie.transform_inertia(axode.lie.exp([0, 0, 0, 0.02, 0, 0.1]), axode.lie.cylinder_inertia(1.5, 0.03, 0.2))
built = drawn.with_payload("flange", tool)

torch.manual_seed(1)
torch.set_default_dtype(torch.float64)
noise = 0.1


def measured(n: int, seed: int) -> tuple[torch.Tensor, ...]:
    """Measured samples: q, v, a and tau, n of each."""
    q = torch.tensor(drawn.random(seed=seed, n=n))
    v, a = 4 * torch.rand(2, n, drawn.nv) - 2
    friction = 1.2 * torch.tanh(v / 0.1) * (1 + 0.3 * torch.exp(-(v / 0.4) ** 2)) + 0.5 * v
    return q, v, a, axode.torch.inverse_dynamics(built, q, v, a) + friction + noise * torch.randn(n, drawn.nv)


# %% [markdown]
# A payload has ten parameters, which must make its pseudo-inertia P positive definite. P = L
# Lᵀ is positive definite for any numbers in the lower triangle of L and for any logarithms of
# its diagonal, so that these are learned. Their initial values are those of a ball of 0.2 kg
# at the flange. In the frame of the last link the same matter has the pseudo-inertia C P Cᵀ, C
# being the pose of the flange, and what it adds to the parameters of that link is linear in P.

# %%
class Payload(torch.nn.Module):  # type: ignore[misc, unused-ignore]
    """Inertial parameters of the arm with a payload at its flange."""

    def __init__(self) -> None:
        super().__init__()
        radius, mass = 0.05, 0.2
        self.logarithms = torch.nn.Parameter(torch.tensor([radius, radius, radius, 1.0]).log() + np.log(mass) / 2)
        self.below = torch.nn.Parameter(torch.zeros(6))
        self.C = torch.tensor(drawn.frame_pose("flange")[1])
        self.arm = torch.tensor(drawn.parameters)

    def pseudo_inertia(self) -> torch.Tensor:
        rows, columns = torch.tril_indices(4, 4, -1)
        L = torch.diag(self.logarithms.exp()).index_put((rows, columns), self.below)
        return L @ L.T

    def forward(self) -> torch.Tensor:
        added = axode.torch.inertial_parameters(self.C @ self.pseudo_inertia() @ self.C.T)
        return torch.cat([self.arm[:-10], self.arm[-10:] + added])


class Arm(torch.nn.Module):  # type: ignore[misc, unused-ignore]
    """The torques of the rigid arm, plus those that a small network adds for each joint and its velocity."""

    def __init__(self, with_residual: bool) -> None:
        super().__init__()
        self.payload = Payload()
        self.residual = torch.nn.Sequential(torch.nn.Linear(1, 16), torch.nn.Tanh(), torch.nn.Linear(16, 1))
        torch.nn.init.uniform_(self.residual[0].weight, -10, 10)  # friction changes quickly near rest
        self.with_residual = with_residual

    def forward(self, q: torch.Tensor, v: torch.Tensor, a: torch.Tensor) -> torch.Tensor:
        tau = axode.torch.inverse_dynamics(drawn, q, v, a, parameters=self.payload())
        return tau + self.residual(v[..., None])[..., 0] if self.with_residual else tau


# %% [markdown]
# There is one loss and one backward pass: its gradient goes through
# inverse dynamics to the payload, and directly to the network.

# %%
def learned(with_residual: bool, *data: torch.Tensor) -> Arm:
    q, v, a, tau = data
    arm = Arm(with_residual)
    optimiser = torch.optim.LBFGS(arm.parameters(), max_iter=100, line_search_fn="strong_wolfe")

    def loss() -> torch.Tensor:
        optimiser.zero_grad()
        value = (arm(q, v, a) - tau).square().mean()
        value.backward()
        return value

    optimiser.step(loss)
    return arm


data, q, v, a, tau = measured(200, 1), *measured(1000, 2)
off = [(axode.torch.inverse_dynamics(drawn, q, v, a) - tau).square().mean().sqrt().item()]
for with_residual in (False, True):
    arm = learned(with_residual, *data)
    with torch.no_grad():
        off.append((arm(q, v, a) - tau).square().mean().sqrt().item())

P = arm.payload.pseudo_inertia().detach()
print(f"mass of the payload in kg: {P[3, 3]:.3f}, truly {built.total_mass - drawn.total_mass:.3f}")
print("its center of mass in the flange, mm:", (1000 * P[:3, 3] / P[3, 3]).numpy().round(1), "truly [ 20. 0. 100.]")
print("its pseudo-inertia is positive definite:", bool(torch.linalg.eigvalsh(P).min() > 0))
print("torques off by in N m:", ", ".join(f"{x:.2f} {what}" for x, what in zip(
    off, ("as drawn", "with the payload", "with payload and residual"))), f"(noise {noise})")
