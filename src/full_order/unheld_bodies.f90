! SPDX-License-Identifier: BSD-3-Clause
!> Warns of full-order solutions in which no contact force holds a body that only contact can hold: the place of this body is not
!> unique.
module sig_unheld_bodies
  use sig_body_checks, only: body_name
  use sig_contact_laws, only: contact_laws_t
  use sig_contact_state, only: contact_state_t
  use sig_deck_config, only: deck_config_t
  use sig_kinds, only: rk
  use sig_mechanical_models, only: mechanical_model, mechanical_model_t
  use sig_mesh, only: mesh_t
  use sig_motion_words, only: amplitudes_of_body, bodies_of_motions, motion_text, unheld_motions
  use sig_parameter_space, only: format_point
  use sig_reasons, only: reason_converged
  use sig_rigid_motions, only: rigid_motions_t
  use sig_text, only: join, string_t, to_text
  implicit none(type, external)
  private
  public :: unheld_warning, unheld_without_friction, moving_bodies

contains

  !> Returns a warning if in some of the solutions that converged no contact force holds a body; empty otherwise. It says at how
  !> many points, and names the first point and the bodies that are free there, with their motions.
  function unheld_warning(deck, mesh, motions, points, states) result(warning)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(rigid_motions_t), intent(in) :: motions
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(contact_state_t), intent(in) :: states(:)
    character(:), allocatable :: warning
    real(rk), allocatable :: of_first(:, :), unheld(:, :)
    integer :: first, i, n

    warning = ''
    first = 0
    n = 0
    do i = 1, size(states)
      if (states(i)%reason /= reason_converged) cycle
      unheld = unheld_motions(motions, abs(states(i)%multipliers) > 0)
      if (size(unheld, 2) == 0) cycle
      n = n + 1
      if (n > 1) cycle
      first = i
      of_first = unheld
    end do
    if (n == 0) return
    warning = 'at ' // format_point(deck%state_parameters, points(:, first))
    if (n > 1) warning = 'at ' // to_text(n) // ' points, the first (' // &
      format_point(deck%state_parameters, points(:, first)) // '),'
    warning = warning // ' no contact force holds ' // bodies_text(deck, mesh, motions, of_first) // ' one of many possible'
  end function unheld_warning

  !> Returns `the body 'spring' (translation in z): its displacement and its gaps are`, or the same for several bodies.
  function bodies_text(deck, mesh, motions, unheld) result(text)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(rigid_motions_t), intent(in) :: motions
    !> combinations of the free motions, shape (n_free, n)
    real(rk), intent(in) :: unheld(:, :)
    character(:), allocatable :: text
    type(string_t), allocatable :: names(:)

    names = moving_bodies(deck, mesh, motions, unheld)
    if (size(names) == 1) then
      text = 'the body ' // names(1)%text // ': its displacement and its gaps are'
    else
      text = 'the bodies ' // join(names, ', ') // ': their displacements and their gaps are'
    end if
  end function bodies_text

  !> Returns the combinations of the free motions that only the friction of contacts could hold whose coefficient is 0: one per
  !> column, shape (n_free, n).
  function unheld_without_friction(motions, laws, friction) result(combinations)
    type(rigid_motions_t), intent(in) :: motions
    type(contact_laws_t), intent(in) :: laws
    !> [-] coefficient of each contact, shape (n_contacts)
    real(rk), intent(in) :: friction(:)
    real(rk), allocatable :: combinations(:, :)
    logical :: is_holding(laws%n_forces())
    integer :: k

    is_holding = .true.
    do k = 1, laws%n_contacts
      if (.not. laws%is_tied(k) .and. .not. friction(k) > 0) is_holding(laws%tangents(:laws%n_tangents(k), k)) = .false.
    end do
    combinations = unheld_motions(motions, is_holding)
  end function unheld_without_friction

  !> Returns `'spring' (translation in z)` for each body that takes part in combinations of the free motions.
  function moving_bodies(deck, mesh, motions, combinations) result(names)
    type(deck_config_t), intent(in) :: deck
    type(mesh_t), intent(in) :: mesh
    type(rigid_motions_t), intent(in) :: motions
    !> shape (n_free, n)
    real(rk), intent(in) :: combinations(:, :)
    type(string_t), allocatable :: names(:)
    type(mechanical_model_t) :: model
    integer, allocatable :: bodies(:)
    integer :: i

    model = mechanical_model(deck%mesh%model)
    bodies = bodies_of_motions(motions, combinations)
    allocate (names(size(bodies)))
    do i = 1, size(bodies)
      names(i)%text = body_name(mesh, motions, bodies(i)) // ' (' // &
        motion_text(motions, amplitudes_of_body(motions, combinations, bodies(i)), model%axes) // ')'
    end do
  end function moving_bodies
end module sig_unheld_bodies
