"""Feed-forward torques for many candidate motions at once, on a GPU if there is one."""

# %% [markdown]
# A planner with thousands of candidate motions needs the torques of all of
# them. The inverse dynamics of the arm are written as CUDA code, in which
# each thread computes one state. The source needs no GPU; running it does.

# %%
import axode
import numpy as np

arm = axode.load(axode.robots / "arm7.toml")
source = axode.codegen.c_source(arm, ["inverse_dynamics"], abi="cuda")
cost = source.functions[0]
print(f"{cost.name}_states: {cost.products} products, {cost.sums} sums, {cost.angles} sines and cosines a thread")

# %% [markdown]
# 200 candidates of 100 points each: a swing of every joint about a posture, with random widths and rhythms.

# %%
random = np.random.default_rng(1)
t = np.linspace(0, 2 * np.pi, 100)[None, :, None]
width, rhythm = random.uniform(0.1, 0.6, (200, 1, 7)), random.uniform(4, 12, (200, 1, 1))  # rad, rad/s
q = (0.3 + width * np.sin(t)).reshape(-1, 7)
v = (width * rhythm * np.cos(t)).reshape(-1, 7)
a = (-width * rhythm**2 * np.sin(t)).reshape(-1, 7)

try:
    import axode.cuda
    import cupy  # type: ignore[import-not-found, import-untyped, unused-ignore]
    where = f"on {cupy.cuda.runtime.getDeviceProperties(0)['name'].decode()}"
    gpu = axode.cuda.kernels(arm, ["inverse_dynamics"])
    tau = cupy.asnumpy(gpu.inverse_dynamics(cupy.asarray(q), cupy.asarray(v), cupy.asarray(a)))
except (ImportError, RuntimeError) as error:  # no CuPy, no driver, no GPU
    where = f"on the processor ({type(error).__name__}: no GPU that CuPy can use)"
    tau = axode.inverse_dynamics(arm, q, v, a)
print(f"{len(q)} states {where}")

# %% [markdown]
# A candidate is possible if it needs from no drive more torque than that can give.

# %%
peak = np.abs(tau).reshape(200, 100, 7).max(axis=1)
possible = (peak <= arm.effort_limits).all(axis=1)
print(f"possible candidates: {possible.sum()} of 200")
print("largest difference to the library:", f"{np.abs(tau - axode.inverse_dynamics(arm, q, v, a)).max():.0e} N m")
