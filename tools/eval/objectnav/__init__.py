"""ObjectGoal navigation in unknown homes, after the protocol of [U] Sec. V: discrete actions, SR and SPL."""
