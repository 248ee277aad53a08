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
3. Batching (`batch`). CasADi's virtual machine decodes an instruction for every stage anew. Here
   each instruction becomes one operation on a vector with an element a stage, and is decoded once.
4. Transcription (`transcription`). Multiple shooting: a stage's rows hold only its own variables
   and, in the gap x_next - F, the identity on the next stage's states. So the problem's derivatives
   are the stages' non-zeros put one behind the other; nothing is added or searched. All of it is
   small enough to be kept on disk as text.

5. Compilation (`c_code`, `compiled`), where there is a C compiler. The same instructions as C,
   each on as many stages as a register holds (2 to 8), in functions of some hundred of them, which
   a compiler takes in linear time: a minute for a robot, in the background. Until it is done, and
   without a compiler, batching is what there is; the numbers are the same.

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

Batching: on fourteen stages functions are two to three times as fast.

Compilation, ANYmal with 48 intervals, AVX-512, ms by CasADi's batched instructions and compiled:
rows 0.35 and 0.02, Jacobian 2.0 and 0.19, Hessian 8.5 and 0.46. Evaluation is half of a solve
without it; with it some 5 % are left, and Fatrop's own work is the rest.

In a prototype with a single flat expression a jump took 0.54 s as Ipopt has it by CasADi's Opti,
0.14 s with fewer variables and scalar expressions, 0.10 to 0.12 s with Fatrop (48 intervals, two
shared cores). Of a solve, 39 % is Fatrop's step, 28 % the Hessian, 20 % the Jacobian.
"""
