! SPDX-License-Identifier: BSD-3-Clause
!> What the solver active_set asks of contacts with friction or ties: free nodes of their own, and bodies that have no clearance.
module sig_sparse_friction
  use sig_bound_form, only: bound_form_t
  use sig_contact_summary, only: contact_name
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_motion_words, only: unheld_motions
  use sig_parameter_space, only: format_point
  use sig_problem, only: problem_t
  use sig_problem_texts, only: tags_text
  use sig_rounding, only: rounding_of_data
  use sig_text, only: join, to_text
  use sig_unheld_bodies, only: moving_bodies
  implicit none(type, external)
  private
  public :: check_clearance, contact_without_dofs, text_without_dofs

contains

  !> Returns the first contact whose rows are not unknowns of T' K T (sig_bound_form), 1-based; 0: there is none, or contacts only
  !> open and close.
  pure integer function contact_without_dofs(problem) result(contact)
    type(problem_t), intent(in) :: problem
    type(bound_form_t) :: form
    logical :: is_held(size(problem%boundary%is_prescribed))

    contact = 0
    if (problem%laws%is_plain()) return
    is_held = problem%boundary%is_prescribed
    is_held(problem%motions%idle%supports) = .true.
    call form%set_reflectors(problem%force_rows, problem%laws, is_held)
    associate (contacts => problem%laws%contacts_of_forces(), row => findloc(form%norms > 0, .false., dim=1))
      if (row > 0) contact = contacts(row)
    end associate
  end function contact_without_dofs

  !> Returns a sentence about this contact.
  function text_without_dofs(problem, contact) result(text)
    type(problem_t), intent(in) :: problem
    !> 1-based
    integer, intent(in) :: contact
    character(:), allocatable :: text

    associate (entry => problem%rows%contact_entry(contact), tags => problem%mesh%node_tags)
      text = 'contact[' // to_text(entry) // '] (' // contact_name(problem%deck, entry) // ') has none at node ' // &
        tags_text(tags(problem%rows%first_nodes_of(contact)), ' and ') // ' of its first surface'
    end associate
  end function text_without_dofs

  !> Checks that the contacts which touch in the first state of each history hold all bodies, where the deck asks for active_set and
  !> friction or ties: this method does not follow a body through a clearance. Errors: the first point where a body has one, with
  !> the place of the solver in the deck.
  subroutine check_clearance(problem, points, theta, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> [-] values of the problem's terms there, shape (n_terms, n_points)
    real(rk), intent(in) :: theta(:, :)
    type(error_t), allocatable, intent(out) :: error
    real(rk), allocatable :: loose(:, :)
    integer :: i, step

    associate (deck => problem%deck, solver => problem%deck%solver)
      if (problem%laws%is_plain() .or. problem%motions%n_free == 0 .or. solver%type /= 'active_set') return
      step = max(1, deck%history%states%n_times())
      do i = 1, size(points, 2), step
        loose = unheld_motions(problem%motions, touching_rows(problem, theta(:, i)))
        if (size(loose, 2) == 0) cycle
        call make_error(error, 'solver.type is active_set, but contact alone holds ' // &
          join(moving_bodies(deck, problem%mesh, problem%motions, loose), ', ') // ', with a clearance at ' // &
          format_point(deck%state_parameters, points(:, i)) // '; with friction or ties active_set does not follow a body ' // &
          'through a clearance', deck%path, solver%line, solver%column, hint='take solver.type: condensed, or auto')
        return
      end do
    end associate
  end subroutine check_clearance

  !> Returns the rows of contacts that touch or overlap before anything is deformed, shape (n_force_rows). Tied surfaces touch.
  pure function touching_rows(problem, theta) result(is_touching)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: theta(:)
    logical :: is_touching(problem%force_rows%n_rows)
    real(rk) :: opening(problem%laws%n_contacts)
    integer :: k

    is_touching = .false.
    opening = matmul(problem%rows%gap, theta) - problem%rows%apply(problem%boundary%prescribed_displacement(theta))
    do k = 1, size(opening)
      is_touching(problem%laws%rows_of(k)) = problem%laws%is_tied(k) .or. &
        opening(k) <= rounding_of_data * maxval(abs(problem%mesh%coordinates))
    end do
  end function touching_rows
end module sig_sparse_friction
