"""A robot's own wire: its messages and motors, DDS, and a simulated robot behind them."""
