! SPDX-License-Identifier: BSD-3-Clause
!> Chooses the reduced integration domain of a model from the interpolation points of its modes, the zones of interest of the deck,
!> and the nodes with prescribed displacements.
module sig_training_domain
  use sig_contact_cover, only: missing_rows, rows_next_to_close
  use sig_contact_rows, only: contact_rows_t
  use sig_deim, only: deim_rows
  use sig_errors, only: error_t
  use sig_kinds, only: rk
  use sig_mesh_checks, only: nodes_of_boundary
  use sig_problem, only: problem_t
  use sig_reduced_domain, only: build_reduced_domain, nodes_of_dofs, reduced_domain_t
  use sig_term_values, only: evaluate_points
  use sig_ties, only: tie_tolerance
  use sig_training_set, only: training_set_t
  use sig_zone_nodes, only: find_zone_nodes
  implicit none(type, external)
  private
  public :: choose_domain

contains

  !> Builds the reduced integration domain around the interpolation nodes (DEIM) of the modes, the nodes of the contact rows that
  !> DEIM of dual_modes chooses, the zones of interest and moved_nodes. With auto in reduction.zones_of_interest, or if this domain
  !> has no contact row, it is built again with more contact rows if lacking_rows finds some.
  !>
  !> Errors: the mesh lacks a boundary of the deck; no node lies in a window.
  subroutine choose_domain(problem, snapshots, contact_values, modes, dual_modes, domain, moved_nodes, error)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    !> [length] from snapshot_contact_values
    real(rk), intent(in) :: contact_values(:, :)
    !> V, shape (n_dofs, n_modes)
    real(rk), intent(in) :: modes(:, :)
    !> modes of the contact forces, shape (n_multipliers, n_dual_modes)
    real(rk), intent(in) :: dual_modes(:, :)
    type(reduced_domain_t), intent(out) :: domain
    !> nodes on which prescribed displacements are imposed as equations, natural; none with a lifting; repetitions are possible
    integer, allocatable, intent(out) :: moved_nodes(:)
    type(error_t), allocatable, intent(out) :: error
    type(contact_rows_t) :: dual_rows
    integer, allocatable :: contact_nodes(:), seeds(:), zone(:)

    call find_zone_nodes(problem, snapshots%parameters, zone, error)
    if (allocated(error)) return
    call find_moved_nodes(problem, moved_nodes, error)
    if (allocated(error)) return
    dual_rows = problem%rows%select(deim_rows(dual_modes))
    contact_nodes = nodes_of_dofs(dual_rows%dofs, problem%mesh%n_dim)
    seeds = [nodes_of_dofs(deim_rows(modes), problem%mesh%n_dim), contact_nodes, moved_nodes, zone]
    call build_reduced_domain(problem%mesh, problem%rows, seeds, domain)
    dual_rows = problem%rows%select(lacking_rows(problem, snapshots, contact_values, domain))
    if (dual_rows%n_rows == 0) return
    contact_nodes = nodes_of_dofs(dual_rows%dofs, problem%mesh%n_dim)
    call build_reduced_domain(problem%mesh, problem%rows, [seeds, contact_nodes], domain)
  end subroutine choose_domain

  !> Returns the contact rows that must be added to a domain.
  !>
  !> Paper: there the domain has enough contact rows by the interpolation points of the displacement modes. That is not always so.
  !> Without a closed row the reduced problem has no contact forces, and nothing in its answer shows the error. Without auto in
  !> reduction.zones_of_interest, rows are added only to a domain without any contact row. The rows are those of missing_rows. Where
  !> no contact is closed in any snapshot and the domain has no contact row, the row with the smallest opening of each snapshot is
  !> added, because contact is expected to begin there.
  function lacking_rows(problem, snapshots, contact_values, domain) result(rows)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    !> [length] from snapshot_contact_values
    real(rk), intent(in) :: contact_values(:, :)
    type(reduced_domain_t), intent(in) :: domain
    !> numbers of contact rows, 1-based; empty where none must be added
    integer, allocatable :: rows(:)
    real(rk), allocatable :: openings(:, :), theta(:, :)
    integer :: i_bad_point, i_bad_source, n

    allocate (rows(0))
    if (problem%rows%n_rows == 0) return
    if (size(domain%contact_rows) > 0 .and. .not. problem%deck%reduction%has_loaded_zones) return
    rows = missing_rows(snapshots%forces(), domain%contact_rows)
    if (size(rows) + size(domain%contact_rows) > 0) return
    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    n = problem%rows%n_rows
    openings = matmul(problem%rows%gap, theta) - (contact_values(:n, :) - contact_values(n + 1:, :))
    rows = rows_next_to_close(openings)
  end function lacking_rows

  !> Finds the nodes on which prescribed displacements are imposed as equations. Each boundary condition adds the middle node of its
  !> boundary if a node of this boundary has a prescribed displacement that is not zero, by this condition or by another one.
  !> There are none where the deck uses a lifting instead. Errors: the mesh lacks a boundary.
  !>
  !> Paper: section 5.1 adds "two nodes on the top and bottom surfaces".
  subroutine find_moved_nodes(problem, nodes, error)
    type(problem_t), intent(in) :: problem
    !> natural (order of the mesh file)
    integer, allocatable, intent(out) :: nodes(:)
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: candidates(:)
    integer :: i

    nodes = [integer ::]
    if (problem%deck%reduction%dirichlet /= 'multiplier') return
    do i = 1, size(problem%deck%boundary_conditions)
      call nodes_of_boundary(problem%mesh, problem%deck%boundary_conditions(i)%boundary, problem%deck%path, candidates, error)
      if (allocated(error)) return
      if (is_moved(problem, candidates)) nodes = [nodes, middle_node(problem%mesh%coordinates(:, candidates), candidates)]
    end do
  end subroutine find_moved_nodes

  !> Whether a displacement that is prescribed at one of the nodes has a value that is not zero for some term.
  pure logical function is_moved(problem, nodes)
    type(problem_t), intent(in) :: problem
    !> natural (order of the mesh file)
    integer, intent(in) :: nodes(:)
    logical :: is_here(problem%mesh%n_nodes)
    integer :: i

    is_here = .false.
    is_here(nodes) = .true.
    is_moved = .false.
    do i = 1, size(problem%boundary%prescribed_dofs)
      if (.not. is_here((problem%boundary%prescribed_dofs(i) - 1) / problem%mesh%n_dim + 1)) cycle
      is_moved = is_moved .or. any(abs(problem%boundary%prescribed_values(i, :)) > 0)
    end do
  end function is_moved

  !> Returns the node nearest to the mean position of the given nodes; of nearly equally near ones the lowest number.
  pure integer function middle_node(coordinates, nodes)
    !> [length] of these nodes, shape (n_dim, size(nodes))
    real(rk), intent(in) :: coordinates(:, :)
    !> natural, ascending
    integer, intent(in) :: nodes(:)
    real(rk) :: distances(size(nodes))

    distances = norm2(coordinates - spread(sum(coordinates, dim=2) / size(nodes), 2, size(nodes)), dim=1)
    middle_node = nodes(findloc(distances <= minval(distances) + tie_tolerance * maxval(distances), .true., dim=1))
  end function middle_node
end module sig_training_domain
