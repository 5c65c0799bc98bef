! SPDX-License-Identifier: BSD-3-Clause
!> Reasons why a solver or a model has an answer at a parameter point, or has none. All layers and files use these numbers.
module sig_reasons
  implicit none(type, external)
  private
  public :: reason_text, put_reason

  !> > 0: there is an answer; < 0: there is none
  integer, parameter, public :: reason_converged = 1

  ! reasons of the full-order model
  integer, parameter, public :: reason_max_iterations = -1
  integer, parameter, public :: reason_linear_solver = -3
  integer, parameter, public :: reason_floating_body = -4
  integer, parameter, public :: reason_no_complementary_solution = -5
  integer, parameter, public :: reason_line_search = -6
  !> reason of a condensed model, too
  integer, parameter, public :: reason_pulled_off = -7
  !> friction cannot hold a body
  integer, parameter, public :: reason_sliding = -8
  !> no equilibrium of a material that flows was found
  integer, parameter, public :: reason_no_material_answer = -9
  !> a property of such a material is out of its range
  integer, parameter, public :: reason_bad_property = -10

  ! reasons of a reduced model
  !> the point does not have one value for each parameter
  integer, parameter, public :: reason_bad_point = -11
  !> a term of the model is infinite or not a number there
  integer, parameter, public :: reason_bad_term = -12
  !> the certificate does not reach certificate.max_error, and the model has no better answer
  integer, parameter, public :: reason_large_bound = -13
  !> tied: a contact that is open, or closed, at all training points of a cluster is not so at this point
  integer, parameter, public :: reason_outside = -15
  !> the same with friction: such a contact opens, closes or slips
  integer, parameter, public :: reason_outside_friction = -14
  !> nothing touches in the reduced integration domain, but the loads or the gaps say that something does elsewhere
  integer, parameter, public :: reason_blind = -16
  !> the reduced stiffness is singular with the elastic constants of the point
  integer, parameter, public :: reason_singular = -17
  !> Young's modulus is not positive there, or Poisson's ratio is not between -1 and 0.5
  integer, parameter, public :: reason_no_material = -18
  !> loads do work on a motion of a body that nothing holds
  integer, parameter, public :: reason_driven = -19
  !> the model remembers, and a state was asked alone
  integer, parameter, public :: reason_needs_history = -20
  !> a coefficient of friction is negative there
  integer, parameter, public :: reason_no_friction = -21

  ! reasons of a dense complementarity problem
  !> an entry of the matrix or of q is not finite
  integer, parameter, public :: reason_not_finite = -21
  !> Lemke's path ended on a secondary ray: most often there is no solution
  integer, parameter, public :: reason_ray = -22
  !> more steps than the method allows
  integer, parameter, public :: reason_max_pivots = -23
  !> an answer was found, but round-off has spoiled it
  integer, parameter, public :: reason_ill_conditioned = -24
  !> no set of closed contacts that was tried is the answer; the next method continues
  integer, parameter, public :: reason_cycle = -25
  !> no states of contacts with friction that were tried are the answer
  integer, parameter, public :: reason_unsolved_friction = -26

  !> length of the longest sentence
  integer, parameter, public :: reason_length = 256

contains

  !> Returns the reason as a sentence without its full stop; `unknown reason` for another number.
  pure function reason_text(reason) result(text)
    integer, intent(in) :: reason
    character(:), allocatable :: text
    character(reason_length) :: sentence

    call put_reason(reason, sentence)
    text = trim(sentence)
  end function reason_text

  !> Writes the reason as a sentence without its full stop. Unlike reason_text it is safe for several threads: gfortran 12 keeps the
  !> lengths of what text functions return in static variables.
  pure subroutine put_reason(reason, text)
    integer, intent(in) :: reason
    !> length of at least reason_length
    character(*), intent(out) :: text

    select case (reason)
    case (reason_converged)
      text = 'converged'
    case (reason_max_iterations)
      text = 'the solver did not converge within solver.max_iterations steps'
    case (reason_linear_solver)
      text = 'the linear solver failed'
    case (reason_floating_body)
      text = 'the stiffness is singular: a body is not held'
    case (reason_no_complementary_solution)
      text = 'the linear complementarity problem has no solution that the pivoting methods find'
    case (reason_line_search)
      text = 'the solver snesvi diverged, or its line search found no descent'
    case (reason_pulled_off)
      text = 'there is no equilibrium: the loads pull a body off the contacts that hold it'
    case (reason_sliding)
      text = 'there is no equilibrium: a body slides, because friction cannot hold it against the loads'
    case (reason_no_material_answer)
      text = 'no equilibrium was found where materials flow, even by short steps: the load may be above what they carry'
    case (reason_bad_property)
      text = 'a value of plasticity or creep is not finite or out of its range at an integration point'
    case (reason_bad_point)
      text = 'the point needs one value for each parameter'
    case (reason_bad_term)
      text = 'a term of the model is infinite or not a number at this point'
    case (reason_large_bound)
      text = 'the error may be larger than certificate.max_error allows'
    case (reason_outside)
      text = 'a contact opens or closes that does not change at the training points nearby'
    case (reason_outside_friction)
      text = 'a contact opens, closes or slips that does not change at the training points'
    case (reason_blind)
      text = 'no contact closes in the reduced integration domain, but the loads or gaps close contacts elsewhere'
    case (reason_singular)
      text = 'the reduced stiffness is singular with the elastic constants of this point'
    case (reason_no_material)
      text = 'Young''s modulus is not positive at this point, or Poisson''s ratio is not between -1 and 0.5'
    case (reason_driven)
      text = 'there is no equilibrium: the loads drive a body in a motion that nothing holds'
    case (reason_no_friction)
      text = 'a coefficient of friction is negative at this point'
    case (reason_needs_history)
      text = 'the model remembers: a state depends on those before it; ask for the history from its beginning'
    case default
      call put_lcp_reason(reason, text)
    end select
  end subroutine put_reason

  pure subroutine put_lcp_reason(reason, text)
    integer, intent(in) :: reason
    character(*), intent(out) :: text

    select case (reason)
    case (reason_not_finite)
      text = 'the complementarity problem has an entry that is not a finite number'
    case (reason_ray)
      text = 'the complementarity problem has no solution that Lemke''s method can reach'
    case (reason_max_pivots)
      text = 'the complementarity problem took more pivots than allowed'
    case (reason_ill_conditioned)
      text = 'the complementarity problem is too ill-conditioned for a reliable answer'
    case (reason_cycle)
      text = 'no set of closed contacts that was tried solves the complementarity problem'
    case (reason_unsolved_friction)
      text = 'the states of the contacts with friction (open, stick, slip) were not found'
    case default
      text = 'unknown reason'
    end select
  end subroutine put_lcp_reason
end module sig_reasons
