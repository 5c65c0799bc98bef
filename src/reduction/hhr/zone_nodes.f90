! SPDX-License-Identifier: BSD-3-Clause
!> Zones of interest: nodes that are added to the reduced integration domain because the deck names them or because they are loaded.
module sig_zone_nodes
  use sig_deck_box, only: max_corner_parameters
  use sig_deck_config, only: deck_config_t, point_set_config_t
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_mesh_checks, only: nodes_of_boundary, nodes_of_zone
  use sig_parameter_space, only: build_states
  use sig_problem, only: problem_t
  use sig_term_values, only: term_values_t
  implicit none(type, external)
  private
  public :: find_zone_nodes, find_loaded_nodes

contains

  !> Returns the nodes of find_loaded_nodes (where the deck asks for them by `auto`) and of the zones that the deck names;
  !> repetitions are possible.
  !>
  !> Errors: the mesh lacks a boundary; no node lies in a window.
  subroutine find_zone_nodes(problem, training_points, nodes, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: training_points(:, :)
    !> natural (order of the mesh file)
    integer, allocatable, intent(out) :: nodes(:)
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: more(:)
    integer :: i

    nodes = [integer ::]
    if (problem%deck%reduction%has_loaded_zones) call find_loaded_nodes(problem, training_points, nodes, error)
    if (allocated(error)) return
    do i = 1, size(problem%deck%reduction%zones_of_interest)
      call nodes_of_zone(problem%mesh, problem%deck%reduction%zones_of_interest(i), problem%deck%path, more, error)
      if (allocated(error)) return
      nodes = [nodes, more]
    end do
  end subroutine find_zone_nodes

  !> Returns the nodes of loaded surfaces that carry a force at a training point or, with up to 10 parameters, at a corner of the
  !> box; ascending, each once. Body forces alone add no node, because they act on all nodes of a region; but a node
  !> of such a surface counts also where only a body force acts on it.
  !>
  !> Errors: the mesh lacks a boundary.
  subroutine find_loaded_nodes(problem, training_points, nodes, error)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: training_points(:, :)
    !> natural (order of the mesh file)
    integer, allocatable, intent(out) :: nodes(:)
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: of_surface(:)
    logical :: is_loaded(problem%mesh%n_nodes), is_loaded_at_corner(problem%mesh%n_nodes), is_zone(problem%mesh%n_nodes)
    integer :: i

    nodes = [integer ::]
    is_zone = .false.
    is_loaded = has_load(problem, training_points)
    if (size(problem%deck%parameters) <= max_corner_parameters) then
      is_loaded_at_corner = has_load(problem, corners(problem%deck))
      is_loaded = is_loaded .or. is_loaded_at_corner
    end if
    do i = 1, size(problem%deck%loads)
      if (problem%deck%loads(i)%is_body_force) cycle
      call nodes_of_boundary(problem%mesh, problem%deck%loads(i)%target, problem%deck%path, of_surface, error)
      if (allocated(error)) return
      is_zone(of_surface) = is_loaded(of_surface)
    end do
    nodes = pack([(i, i=1, size(is_zone))], is_zone)
  end subroutine find_loaded_nodes

  !> Returns the corners of the box of the parameters, with a history all states there; none where a table is not valid.
  function corners(deck) result(points)
    type(deck_config_t), intent(in) :: deck
    real(rk), allocatable :: points(:, :)
    type(point_set_config_t) :: both_ends
    type(error_t), allocatable :: error

    both_ends%grid = spread(2, 1, size(deck%parameters))
    call build_states(deck, both_ends, points, error)
    if (allocated(error)) allocate (points(size(deck%state_parameters), 0))
  end function corners

  !> Whether a load, body forces included, has a force on each node that is not zero at one of the points. Forces of several terms
  !> count even if their sum is zero. A point where a term has no finite value does not count.
  function has_load(problem, points) result(is_loaded)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    logical :: is_loaded(problem%mesh%n_nodes)
    type(term_values_t) :: values
    character(:), allocatable :: message
    real(rk) :: theta(problem%terms%n_terms())
    logical :: is_used(problem%terms%n_terms()), is_valid
    integer :: i, i_bad_source

    is_loaded = .false.
    is_used = .false.
    call values%create(problem%terms, message)
    do i = 1, size(points, 2)
      call values%evaluate(points(:, i), theta, is_valid, i_bad_source)
      if (is_valid) is_used = is_used .or. abs(theta) > 0
    end do
    call values%destroy()
    associate (loads => problem%boundary%loads)
      do i = 1, loads%n_entries()
        if (abs(loads%values(i)) > 0 .and. is_used(loads%terms(i))) &
          is_loaded((loads%dofs(i) - 1) / problem%mesh%n_dim + 1) = .true.
      end do
    end associate
  end function has_load
end module sig_zone_nodes
