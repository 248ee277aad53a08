"""Sentences with which jobs are refused or given up."""

from app.workers.member import SILENCE
from app.workers.waiting import MOST_WAITING

CLOSED = "The server is closing."
BUSY = f"The server is busy: {MOST_WAITING} requests are waiting. Please try again in a moment."
DEFECT = "A defect of the server interrupted this; please try again."
BROKEN = "Internal error: planning has stopped; see the server log."
SILENT = f"It gave no sign of life for {SILENCE / 60:g} minutes and was stopped."
LATE = "It took more than {limit:g} s and was stopped."
