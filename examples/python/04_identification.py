"""The parameters of an arm from motions and torques with noise, outliers, joint losses and a tool nobody has drawn."""

# %% [markdown]
# The measured arm is that of the drawing, but heavier, with friction in its joints and a tool at its flange.
# Torques have noise of 0.5 % of the largest torques of the drives, and one of fifty is completely wrong.

# %%
import axode
import numpy as np

drawn = axode.load(axode.robots / "arm7.toml")
drawing = drawn.with_parameters(1.1 * drawn.parameters).to_dict()
for body in drawing["body"]:
    if isinstance(body["joint"], dict) and body["joint"]["kind"] == "revolute":
        body["joint"] |= {"damping": 0.8, "friction": 1.5}
tool = axode.lie.transform_inertia(axode.lie.exp([0, 0, 0, 0, 0, 0.1]), axode.lie.cylinder_inertia(1.5, 0.03, 0.2))
built = axode.Model.from_dict(drawing).with_payload("flange", tool, name="tool")

random = np.random.default_rng(4)
t = np.linspace(0, 20, 2000)[:, None]  # s
q, v, a = np.zeros((3, len(t), drawn.nv))
for harmonic in range(1, 6):  # a Fourier series for each joint
    rate = 2 * np.pi * harmonic / 10
    phase, size = random.uniform(0, 2 * np.pi, 7), random.uniform(0.1, 0.3, 7)
    q += size * np.sin(rate * t + phase)
    v += size * rate * np.cos(rate * t + phase)
    a -= size * rate**2 * np.sin(rate * t + phase)
noise = 0.005 * drawn.effort_limits
tau = axode.inverse_dynamics(built, q, v, a, joint_losses=True) + noise * random.normal(size=v.shape)
wrong = random.random(tau.shape) < 0.02
tau[wrong] += 100 * noise[np.nonzero(wrong)[1]]

# %% [markdown]
# The motions depend only on the base parameters. The model
# that is found has these, and is physically consistent.

# %%
found = axode.identification.identify(drawn, q, v, a, tau, joint_losses=True, robust=True)
print(f"{len(found.parameters)} parameters, {found.rank} of their combinations in these torques; "
      f"condition {found.condition:.0f}")

print("\nthe best known of them           found     true   deviation")
true = found.base_matrix @ np.append(built.parameters, [0.8] * 7 + [1.5] * 7)
losses = ("damping", "friction")
inertial = [k for k in range(found.rank) if not any(loss in found.base_names[k] for loss in losses)]
for k in sorted(inertial, key=lambda k: -abs(found.base_parameters[k]) / found.base_deviations[k])[:6]:
    value, deviation = found.base_parameters[k], found.base_deviations[k]
    print(f"{found.base_names[k][:29]:29} {value:8.4f} {true[k]:8.4f} {deviation:11.4f}")

print("\njoint  damping  friction  noise, found and true")
for name, joint, s, s_true in zip(found.model.velocity_names, found.model.joints, found.noise, noise):
    print(f"{name:5} {joint.damping[0]:8.3f} {joint.friction[0]:9.3f} {s:7.3f} {s_true:7.3f}")

# %% [markdown]
# The model is tested with another motion.

# %%
q, v, a = drawn.random(seed=1, n=500), *random.uniform(-2, 2, (2, 500, 7))
expected = axode.inverse_dynamics(built, q, v, a, joint_losses=True)
for name, m in [("drawn", drawn), ("found", found.model)]:
    error = axode.inverse_dynamics(m, q, v, a, joint_losses=True) - expected
    print(f"torques of the {name} model are off by {np.sqrt(np.mean(error**2)):.2f} N m")
eigenvalues = np.linalg.eigvalsh(axode.identification.pseudo_inertia(found.model.parameters.reshape(-1, 10)))
print("every body can be built:", bool(eigenvalues.min() > 0))
