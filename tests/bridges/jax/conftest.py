"""What is compiled here is run a few times: XLA shall not take long over it."""

import jax

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_disable_most_optimizations", True)
