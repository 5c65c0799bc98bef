! SPDX-License-Identifier: BSD-3-Clause
!> Idle motions, which nothing holds, and the loads: a load that does work on such a motion drives the body away.
module sig_idle_loads
  use sig_body_checks, only: body_name
  use sig_boundary_conditions, only: boundary_conditions_t
  use sig_deck_units, only: force_unit, moment_unit
  use sig_errors, only: error_t, make_error
  use sig_idle_work, only: idle_work_t
  use sig_kinds, only: rk
  use sig_load_pattern, only: load_pattern_t
  use sig_loads, only: create_loads
  use sig_mechanical_models, only: coordinate_names, mechanical_model, mechanical_model_t
  use sig_motion_words, only: motion_text
  use sig_parameter_space, only: format_point
  use sig_problem, only: parameter_names, problem_t
  use sig_rigid_bodies, only: null_space
  use sig_rigid_motions, only: rigid_motions_t
  use sig_term_set, only: start_terms, term_set_t
  use sig_term_values, only: evaluate_points
  use sig_text, only: fine_digits, short_number
  implicit none(type, external)
  private
  public :: check_idle_loads

  !> One motion at a point where loads drive it.
  type :: driven_motion_t
    !> [-] shares of the idle motions in it, of length 1, shape (n)
    real(rk), allocatable :: shares(:)
    !> [-] amplitudes of the rigid modes of each body, shape (n_rigid, n_bodies)
    real(rk), allocatable :: amplitudes(:, :)
    !> a body that it moves, 1-based
    integer :: i_body = 0
    !> whether the body rotates
    logical :: is_rotation = .false.
  end type driven_motion_t

  !> [-] a share of the work up to this one is none
  real(rk), parameter :: small = 1.0e-6_rk

contains

  !> Checks that the loads do no work on idle motions. Errors: the first point where they do; the message names the load that does
  !> most of this work, the body, its motion, and the force along a translation or the moment about the axis of a rotation.
  subroutine check_idle_loads(problem, points, theta, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> [-] values of the problem's terms there, shape (n_terms, n_points)
    real(rk), intent(in) :: theta(:, :)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    if (problem%motions%idle%n == 0) return
    do i = 1, size(points, 2)
      if (problem%idle_work%is_zero(theta(:, i))) cycle
      call refuse_load(problem, points(:, i), problem%idle_work%at(theta(:, i)), error)
      return
    end do
  end subroutine check_idle_loads

  !> Makes the error of check_idle_loads.
  subroutine refuse_load(problem, point, work, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> [force] work of all loads on each idle motion, not zero
    real(rk), intent(in) :: work(:)
    type(error_t), allocatable, intent(out) :: error
    type(driven_motion_t) :: motion
    type(mechanical_model_t) :: model
    real(rk) :: of_load(size(problem%deck%loads)), total
    integer :: i

    call find_motion(problem%motions, work, motion)
    do i = 1, size(of_load)
      of_load(i) = dot_product(work_of_load(problem, i, point), motion%shares)
    end do
    total = dot_product(work, motion%shares)
    i = maxloc(of_load, dim=1)
    model = mechanical_model(problem%deck%mesh%model)
    associate (target => problem%deck%loads(i)%target)
      call make_error(error, 'the load on ''' // target%text // ''' drives the body ' // &
        body_name(problem%mesh, problem%motions, motion%i_body) // ', which nothing holds (' // &
        motion_text(problem%motions, motion%amplitudes(:, motion%i_body:motion%i_body), model%axes) // '), with ' // &
        amount(of_load(i)) // others() // ' at ' // format_point(problem%deck%state_parameters, point), problem%deck%path, &
        target%line, target%column, 'prescribe a displacement that prevents this motion, or change the loads so that their ' // &
        'sum does not drive it at any point')
    end associate

  contains

    !> Returns the force or moment that does some work on the motion, with its unit.
    function amount(work_done) result(text)
      real(rk), intent(in) :: work_done
      character(:), allocatable :: text
      real(rk) :: size_of

      size_of = work_done / length_of(problem%motions, motion)
      if (motion%is_rotation) then
        text = 'a moment of ' // short_number(size_of, fine_digits) // ' ' // moment_unit(problem%deck)
      else
        text = 'a force of ' // short_number(size_of, fine_digits) // ' ' // force_unit(problem%deck)
      end if
    end function amount

    !> Says how much all loads do, if it differs from what the named one does.
    function others() result(text)
      character(:), allocatable :: text

      text = ''
      if (abs(total - of_load(i)) > small * abs(of_load(i))) text = ' (all loads together: ' // amount(total) // ')'
    end function others
  end subroutine refuse_load

  !> Finds the motion on which the loads do most work: of the body on whose motions they do most, a translation if there is one on
  !> which they do work.
  subroutine find_motion(motions, work, motion)
    type(rigid_motions_t), intent(in) :: motions
    real(rk), intent(in) :: work(:)
    type(driven_motion_t), intent(out) :: motion
    real(rk), allocatable :: shifts(:, :)
    integer, allocatable :: own(:)
    integer :: i

    associate (idle => motions%idle, n_dim => size(motions%coordinates, 1))
      motion%i_body = idle%carriers(maxloc(abs(work), dim=1))
      own = pack([(i, i=1, idle%n)], idle%carriers == motion%i_body)
      allocate (motion%shares(idle%n), source=0.0_rk)
      motion%shares(own) = work(own)
      if (.not. motions%is_round) then
        associate (rotations => idle%amplitudes(n_dim + 1:, motion%i_body, own))
          shifts = null_space(matmul(transpose(rotations), rotations))
        end associate
        motion%is_rotation = norm2(matmul(work(own), shifts)) <= small * norm2(work(own))
        if (.not. motion%is_rotation) motion%shares(own) = matmul(shifts, matmul(work(own), shifts))
      end if
      motion%shares = motion%shares / norm2(motion%shares)
      motion%amplitudes = reshape(matmul(reshape(idle%amplitudes, [motions%n_rigid * motions%n_bodies, idle%n]), motion%shares), &
        [motions%n_rigid, motions%n_bodies])
    end associate
  end subroutine find_motion

  !> Returns the distance [-] by which the motion shifts the body or, for a rotation, its angle [1/length].
  pure real(rk) function length_of(motions, motion)
    type(rigid_motions_t), intent(in) :: motions
    type(driven_motion_t), intent(in) :: motion

    associate (own => motion%amplitudes(:, motion%i_body), n_dim => size(motions%coordinates, 1))
      if (motion%is_rotation) then
        length_of = norm2(own(n_dim + 1:)) / motions%sizes(motion%i_body)
      else
        length_of = norm2(own)
      end if
    end associate
  end function length_of

  !> Returns the work [force] of one load of the deck on each idle motion at a point.
  function work_of_load(problem, i_load, point) result(work)
    type(problem_t), intent(in) :: problem
    integer, intent(in) :: i_load
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    real(rk) :: work(problem%motions%idle%n)
    type(error_t), allocatable :: error
    type(load_pattern_t) :: pattern
    type(mechanical_model_t) :: model
    type(term_set_t) :: terms
    real(rk), allocatable :: theta(:, :)
    real(rk) :: sizes(size(work))
    integer :: i_bad_point, i_bad_source

    work = 0
    model = mechanical_model(problem%deck%mesh%model)
    call start_terms(parameter_names(problem%deck), coordinate_names(model), model%is_round, terms)
    call create_loads(problem%mesh, problem%body, problem%deck%loads(i_load:i_load), problem%deck%path, terms, pattern, error)
    if (allocated(error) .or. pattern%n_entries() == 0) return
    call evaluate_points(terms, reshape(point, [size(point), 1]), theta, i_bad_point, i_bad_source)
    call problem%motions%idle%work(problem%motions, pattern%dofs, pattern%values * theta(pattern%terms, 1), work, sizes)
  end function work_of_load
end module sig_idle_loads
