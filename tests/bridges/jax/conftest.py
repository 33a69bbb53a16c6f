"""Sets options with which XLA compiles quickly, because these tests run each compiled function only a few times."""

import jax

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_disable_most_optimizations", True)
