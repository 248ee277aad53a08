"""Optimal control without robots: stages with expressions in, `Problem` -> `Solution` out.

A problem is described once (`horizon`): stages in a row, each with its variables, states first, its
cost, its path constraints and the next stage's state, as CasADi expressions of parameters.
`transcription` makes one parametric problem of it, and `solvers` solve it for any numbers, from a
guess or from the solution of a problem nearby.

How derivatives become exact, fast and small
============================================
An interior-point solver evaluates the Jacobian of all rows and the Hessian of the Lagrangian in
every iteration. Written as one flat expression of the whole horizon that is slow, and needs a
compiler (52 MB of C for the robots' problem) to become bearable. Five steps, each on the other:

1. Lifting (`lifting`). A stage's expression is deep: what a constraint holds is a function of
   quantities that are functions of others. Differentiating it written out costs one sweep through
   all of it for every variable. So quantities on the way are marked, and the chain rule runs over
   the small sparse blocks between them. Nothing is approximated, and the marked quantities do not
   become variables of the problem.
2. Stage functions (`stage_functions`). Stages of one family, such as all the inner ones of a
   phase, have the same expressions. Each family is differentiated once, into functions of one
   stage's variables that give the non-zeros of its own part of the derivatives. What differs
   between stages of a family is a parameter of their own.
3. Batching (`stage_functions`). CasADi's virtual machine decodes an instruction for every stage
   anew. Here each instruction becomes one operation on a vector with an element a stage, and is
   decoded once.
4. Transcription (`transcription`). Multiple shooting: a stage's rows hold only its own variables
   and, in the gap x_next - F, the identity on the next stage's states. So the problem's derivatives
   are the stages' non-zeros put one behind the other; nothing is added or searched. All of it is
   small enough to be kept on disk as text.
5. Compilation (`compiled`), where there is a C compiler: a minute for a robot, in the background.
   Until it is done, and without a compiler, batching is what there is; the numbers are the same.

Fatrop knows this structure (`Structure`) and finds its step by a Riccati recursion over the
stages, in a time linear in their number; Ipopt takes the same functions and factorises a general
sparse matrix.

What each brings
----------------
Lifting, in instructions of one inner stage of a quadruped's jump (`llsrbm-plus`); the rows alone
take 3,260 and 3,091:

                        Jacobian             Hessian
    stance              27,706 of 48,716     50,235 of 121,890 without lifting
    flight              11,827 of 17,201     30,411 of  48,203

docs/figures.md has what batching and compilation bring.
"""
