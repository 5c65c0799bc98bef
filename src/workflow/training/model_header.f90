! SPDX-License-Identifier: BSD-3-Clause
!> Fills the data of a model that do not depend on its clusters: origin, parameters, terms, mesh nodes and contact rows.
module sig_model_header
  use sig_deck_echo, only: echo_deck
  use sig_deck_units, only: force_unit
  use sig_model, only: contact_side_t, model_t
  use sig_problem, only: parameter_names, parameter_units, problem_t
  use sig_resultants_of_contact, only: create_resultant_map
  use sig_training_set, only: training_set_t
  use sig_version, only: code_version
  implicit none(type, external)
  private
  public :: fill_model_header

contains

  !> Fills the data of the model that come from the deck, the mesh and the contact rows, but not its field map and max_error. Local.
  !> Requires: the header was not filled before.
  subroutine fill_model_header(problem, snapshots, model)
    type(problem_t), intent(in) :: problem
    !> of these only the points are taken, as the training points of the model
    type(training_set_t), intent(in) :: snapshots
    type(model_t), intent(inout) :: model
    integer :: i

    associate (deck => problem%deck)
      model%code_version = code_version
      model%deck_text = echo_deck(deck)
      model%title = deck%title
      model%provenance = problem%provenance
      model%mesh_hash = problem%mesh%file_hash
      model%length_unit = deck%units%length
      model%force_unit = force_unit(deck)
      model%parameter_names = parameter_names(deck)
      model%parameter_units = parameter_units(deck)
      allocate (model%box(2, size(deck%state_parameters)))
      do i = 1, size(deck%state_parameters)
        model%box(:, i) = [deck%state_parameters(i)%minimum, deck%state_parameters(i)%maximum]
      end do
      model%history = deck%history%states
      model%pod_tolerance = deck%reduction%pod_tolerance
      model%dirichlet = deck%reduction%dirichlet
    end associate
    model%training_points = snapshots%parameters
    model%terms = problem%terms
    if (.not. problem%idle_work%has_no_terms()) model%idle_work = problem%idle_work
    call fill_contact(problem, model)
  end subroutine fill_model_header

  subroutine fill_contact(problem, model)
    type(problem_t), intent(in) :: problem
    type(model_t), intent(inout) :: model

    model%n_nodes = problem%mesh%n_nodes
    model%n_dim = problem%mesh%n_dim
    model%n_dofs = problem%mesh%n_dim * problem%mesh%n_nodes
    model%node_tags = problem%mesh%node_tags
    model%coordinates = problem%mesh%coordinates
    model%n_multipliers = problem%force_rows%n_rows
    model%laws = problem%laws
    model%gap = problem%force_rows%gap
    model%areas = problem%force_rows%areas
    call create_resultant_map(problem, model%resultants)
    call fill_side(problem, .false., model%first_side)
    call fill_side(problem, .true., model%second_side)
  end subroutine fill_contact

  subroutine fill_side(problem, is_second, side)
    type(problem_t), intent(in) :: problem
    !> the second side, otherwise the first
    logical, intent(in) :: is_second
    type(contact_side_t), intent(out) :: side
    integer, allocatable :: nodes(:)

    call problem%rows%list_side(is_second, side%starts, nodes, side%weights)
    side%tags = problem%mesh%node_tags(nodes)
    side%coordinates = problem%mesh%coordinates(:, nodes)
  end subroutine fill_side
end module sig_model_header
