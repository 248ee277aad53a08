"""Motions of the library that ships, for tests: opened once a process."""

from functools import cache

from llsrbm.library import shipped

NAME = "go2-together-0001"


@cache
def library():
    return shipped()


@cache
def card(name=NAME):
    return library().card(name)


@cache
def plan(name=NAME):
    return library().open(name, check=False)


def first_of_each_robot():
    """Names, one a robot."""
    found = {}
    for each in library().cards:
        found.setdefault(each.robot, each.name)
    return list(found.values())
