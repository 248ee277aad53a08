"""The commands of `llsrbm`, one module each; `llsrbm.commands.program` puts them together.

Heavy imports happen inside the commands, so that `llsrbm --help` answers at once.
"""
