"""A finger as a chain of links that robot simulators run in real time, with its errors."""
