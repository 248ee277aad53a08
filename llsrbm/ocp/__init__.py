"""Optimal control without robots: stages with expressions in, `Problem` -> `Solution` out.

A problem is described once (`horizon`): stages in a row, each with its variables, states first, its
cost, its path constraints and the next stage's state, as CasADi expressions of parameters.
`transcription` makes one parametric problem of it, and `solvers` solve it for any numbers, from a
guess or from the solution of a problem nearby.

An interior-point solver evaluates the Jacobian of all rows and the Hessian of the Lagrangian in
every iteration. Written as one flat expression of the whole horizon that is slow, and needs a
compiler (52 MB of C for the robots' problem) to become bearable. Six steps, each on the other:

1. Lifting (`lifting`, `derivatives`). A stage's expression is deep. Quantities on the way are
   marked, and what is between neighbours alone is written out; the chain rule is products of their
   small sparse matrices. The Hessian of a quadruped's stance at lift-off takes 54,000 instructions
   and these products; written out through the same marks it takes 210,000.
2. Composition (`composition`). A stage that calls the same functions again and again, as of each
   leg, has them derived once; the chain rule then runs over whole functions.
3. Stage functions (`stage_functions`). Stages of one family, such as all the inner ones of a
   phase, are differentiated once, into functions of one stage's variables that give the non-zeros
   of its own part of the derivatives. Numbers in which they differ are parameters of their own.
4. Batching (`stage_functions`). Each instruction of CasADi's virtual machine that a cost or the
   rows need becomes one operation on a vector with an element a stage, and is decoded once.
5. Transcription (`transcription`). Multiple shooting: a stage's rows hold only its own variables
   and, in the gap x_next - F, the identity on the next stage's states. So the problem's derivatives
   are the stages' non-zeros put one behind the other, small enough to be kept on disk as text.
6. Compilation (`compiled`), where there is a C compiler: half a minute for a robot, in the
   background; the numbers are the same.

Fatrop knows this structure (`Structure`) and finds its step by a Riccati recursion over the stages;
Ipopt takes the same functions and factorises a general sparse matrix. docs/figures.md has what
batching and compilation bring.
"""
