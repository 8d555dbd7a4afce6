"""The battery: how charge and voltage fall while the robot works."""

from dataclasses import dataclass

# Open-circuit voltage of a lithium-ion cell over its charge: flat in the middle, steep at the end.
_CHARGE = (0.0, 0.05, 0.1, 0.2, 0.5, 0.8, 1.0)
_CELL_VOLTAGE = (3.0, 3.3, 3.45, 3.55, 3.7, 3.95, 4.2)


@dataclass(frozen=True)
class BatteryConfig:
    """Three cells, as in small platforms."""

    cells: int = 3
    capacity: float = 5.2 * 3600  # A s
    resistance: float = 0.09  # ohm, cells and wiring
    board_power: float = 6.0  # W; computer, camera, lidar
    stall_power: float = 40.0  # W of both motors at full duty


class Battery:
    """Counts the charge that flows out."""

    def __init__(self, config: BatteryConfig):
        self._config = config
        self.charge = 1.0  # share of the capacity
        self.current = 0.0  # A, flowing out
        self.voltage = self._open_circuit()

    def drain(self, effort: float, seconds: float) -> None:
        """Power the board and the motors; ``effort`` is the mean squared duty of the wheels in [0, 1]."""
        config = self._config
        power = config.board_power + config.stall_power * effort
        self.current = power / max(self.voltage, 1.0)
        self.charge = max(0.0, self.charge - self.current * seconds / config.capacity)
        self.voltage = self._open_circuit() - self.current * config.resistance

    @property
    def voltage_ratio(self) -> float:
        """Voltage over the nominal 3.7 V a cell: what a duty is worth."""
        return self.voltage / (3.7 * self._config.cells)

    def _open_circuit(self) -> float:
        for i in range(1, len(_CHARGE)):
            if self.charge <= _CHARGE[i]:
                share = (self.charge - _CHARGE[i - 1]) / (_CHARGE[i] - _CHARGE[i - 1])
                cell = _CELL_VOLTAGE[i - 1] + share * (_CELL_VOLTAGE[i] - _CELL_VOLTAGE[i - 1])
                return cell * self._config.cells
        return _CELL_VOLTAGE[-1] * self._config.cells
