! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Snapshots -> POD -> interpolation rows -> reduced integration domain -> projected blocks -> model.
module sig_training
  use sig_condition_number, only: condition_number
  use sig_contact_operator, only: contact_operator_t
  use sig_contact_state, only: reason_converged
  use sig_deim, only: deim_rows
  use sig_dirichlet_rows, only: impose_dirichlet_rows
  use sig_errors, only: error_t, exit_not_converged, make_error
  use sig_kinds, only: rk
  use sig_linear_algebra, only: singular_values
  use sig_log, only: log_warning
  use sig_mesh_checks, only: nodes_of_boundary
  use sig_model, only: model_t, reduced_model_t
  use sig_model_header, only: fill_model_header
  use sig_parameter_space, only: format_point
  use sig_pod, only: compute_pod
  use sig_pod_rank, only: pod_rank
  use sig_problem, only: problem_t
  use sig_projection, only: expected_stiffness_rank, project, projected_blocks_t, stiffness_rows_rank
  use sig_reduced_domain, only: build_reduced_domain, nodes_of_dofs, reduced_domain_t
  use sig_snapshot_store, only: snapshot_set_t
  use sig_term_values, only: evaluate_points
  use sig_text, only: append_text, to_text
  use petsc
  implicit none(type, external)
  private
  public :: train

contains

  !> Builds the reduced model of all snapshots. Collective on all ranks; the model is the same on each.
  subroutine train(problem, snapshots, model, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(model_t), intent(out) :: model
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(snapshot_set_t) :: converged

    ierr = 0
    call select_converged(problem, snapshots, converged, error)
    if (allocated(error)) return
    call fill_model_header(problem, converged, model)
    allocate (model%clusters(1))
    PetscCall(train_cluster(problem, converged, model%clusters(1), error, ierr))
  end subroutine train

  !> Leaves out the points that the full-order model did not solve.
  subroutine select_converged(problem, snapshots, converged, error)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(snapshot_set_t), intent(out) :: converged
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: kept(:)
    integer :: i

    converged = snapshots
    kept = pack([(i, i=1, size(snapshots%reasons))], snapshots%reasons == reason_converged)
    if (size(kept) == 0) then
      call make_error(error, 'none of the ' // to_text(size(snapshots%reasons)) // ' training points has a full-order solution', &
        problem%deck%path, exit_code=exit_not_converged)
      return
    end if
    do i = 1, size(snapshots%reasons)
      if (snapshots%reasons(i) == reason_converged) cycle
      call log_warning('training without ' // format_point(problem%deck%parameters, snapshots%parameters(:, i)) // &
        ', which the full-order model did not solve')
    end do
    converged%parameters = snapshots%parameters(:, kept)
    converged%displacement = snapshots%displacement(:, kept)
    converged%multipliers = snapshots%multipliers(:, kept)
  end subroutine select_converged

  !> One local model. Collective on all ranks.
  subroutine train_cluster(problem, snapshots, cluster, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(reduced_model_t), intent(out) :: cluster
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: fields(:, :), vectors(:, :)
    integer, allocatable :: anchors(:), zone(:)
    type(reduced_domain_t) :: domain
    integer :: n_modes

    ierr = 0
    call fields_to_compress(problem, snapshots, fields)
    PetscCall(compute_pod(fields, PETSC_COMM_WORLD, cluster%singular_values, vectors, ierr))
    n_modes = pod_rank(cluster%singular_values, problem%deck%reduction%pod_tolerance)
    if (n_modes == 0) then
      call make_error(error, 'all snapshots are zero: no training point loads the bodies', problem%deck%path)
      return
    end if
    call zone_nodes(problem, zone, error)
    if (allocated(error)) return
    call anchor_nodes(problem, anchors, error)
    if (allocated(error)) return
    call build_reduced_domain(problem%mesh, problem%operator, &
      [nodes_of_dofs(deim_rows(vectors(:, :n_modes)), problem%mesh%n_dim), anchors, zone], domain)
    call keep_domain(domain, cluster)
    call reduce(problem, snapshots, domain, anchors, vectors(:, :n_modes), cluster, error)
    if (allocated(error)) return
    call keep_dual_snapshots(problem, snapshots, cluster)
  end subroutine train_cluster

  !> Whole fields, or what contact adds to the elastic response.
  subroutine fields_to_compress(problem, snapshots, fields)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    real(rk), allocatable, intent(out) :: fields(:, :)
    real(rk), allocatable :: theta(:, :)
    integer :: i_bad_point, i_bad_source

    fields = snapshots%displacement
    if (problem%deck%reduction%dirichlet == 'multiplier') return
    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    fields = fields - matmul(snapshots%free_response, theta(:size(snapshots%free_response, 2), :))
  end subroutine fields_to_compress

  subroutine zone_nodes(problem, nodes, error)
    type(problem_t), intent(in) :: problem
    integer, allocatable, intent(out) :: nodes(:)
    type(error_t), allocatable, intent(out) :: error
    integer, allocatable :: more(:)
    integer :: i

    nodes = [integer ::]
    do i = 1, size(problem%deck%reduction%zones_of_interest)
      call nodes_of_boundary(problem%mesh, problem%deck%reduction%zones_of_interest(i), problem%deck%path, more, error)
      if (allocated(error)) return
      nodes = [nodes, more]
    end do
  end subroutine zone_nodes

  !> Where the prescribed rows are imposed: the middle node of each boundary that the parameters move.
  !>
  !> Paper: section 5.1 adds "two nodes on the top and bottom surfaces". A lifting needs none.
  subroutine anchor_nodes(problem, nodes, error)
    type(problem_t), intent(in) :: problem
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
  end subroutine anchor_nodes

  !> Some prescribed value on the nodes is not zero for all parameters.
  pure logical function is_moved(problem, nodes)
    type(problem_t), intent(in) :: problem
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

  !> Node nearest to the mean of all; the lowest number where two are equally near.
  pure integer function middle_node(coordinates, nodes)
    !> shape (n_dim, size(nodes))
    real(rk), intent(in) :: coordinates(:, :)
    !> ascending
    integer, intent(in) :: nodes(:)
    !> [-] distances this close are equal (symmetric meshes, any BLAS or unit)
    real(rk), parameter :: tie = 1.0e-8_rk
    real(rk) :: distances(size(nodes))

    distances = norm2(coordinates - spread(sum(coordinates, dim=2) / size(nodes), 2, size(nodes)), dim=1)
    middle_node = nodes(findloc(distances <= minval(distances) + tie * maxval(distances), .true., dim=1))
  end function middle_node

  subroutine keep_domain(domain, cluster)
    type(reduced_domain_t), intent(in) :: domain
    type(reduced_model_t), intent(inout) :: cluster

    cluster%seed_nodes = domain%seed_nodes
    cluster%facing_nodes = domain%facing_nodes
    cluster%cells = domain%cells
    cluster%interior_dofs = domain%interior_dofs
    cluster%interface_dofs = domain%interface_dofs
    cluster%contact_dofs = domain%contact_dofs
    cluster%contact_rows = domain%contact_rows
    cluster%n_rows = size(domain%contact_rows)
  end subroutine keep_domain

  !> Projects, and measures what makes the reduced problem solvable: kappa, the rank of (11), cond(K_r), the rank of trap 1.
  subroutine reduce(problem, snapshots, domain, anchors, basis, cluster, error)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(reduced_domain_t), intent(in) :: domain
    integer, intent(in) :: anchors(:)
    !> V, shape (n_dofs, n_modes)
    real(rk), intent(in) :: basis(:, :)
    type(reduced_model_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(out) :: error
    type(projected_blocks_t) :: blocks

    call project(problem%mesh, problem%body, problem%operator, problem%boundary%loads, domain, basis, &
      snapshots%free_response, blocks)
    call condition_number(blocks%contact_matrix, problem%deck%reduction%rank_tolerance, cluster%condition_number, cluster%rank)
    call split_prescribed(problem, snapshots, anchors, basis, cluster, error)
    if (allocated(error)) return
    call project(problem%mesh, problem%body, problem%operator, problem%boundary%loads, domain, cluster%basis, &
      cluster%lifting, blocks)
    cluster%n_modes = size(cluster%basis, 2)
    cluster%reduced_stiffness = blocks%reduced_stiffness
    cluster%contact_matrix = blocks%contact_matrix
    cluster%load = blocks%load
    cluster%gap = blocks%gap
    cluster%primal_rank_expected = expected_stiffness_rank(domain, &
      problem%boundary%loads%loaded_dofs(size(basis, 1)), cluster%n_modes)
    cluster%stiffness_condition = condition_of(blocks%reduced_stiffness)
    call check_solvable(problem, cluster, stiffness_rows_rank(blocks, problem%deck%reduction%rank_tolerance), error)
  end subroutine reduce

  !> Displacement = lifting * theta + basis * gamma, either way of treating the prescribed values.
  subroutine split_prescribed(problem, snapshots, anchors, basis, cluster, error)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    integer, intent(in) :: anchors(:)
    real(rk), intent(in) :: basis(:, :)
    type(reduced_model_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(out) :: error
    !> [-] prescribed values that the modes miss by more than this cannot be imposed
    real(rk), parameter :: representable = 1.0e-6_rk
    integer, allocatable :: rows(:)
    real(rk) :: misfit
    integer :: rank, i

    if (problem%deck%reduction%dirichlet /= 'multiplier') then
      cluster%basis = basis
      cluster%lifting = snapshots%free_response
      return
    end if
    rows = pack([(i, i=1, size(problem%boundary%prescribed_dofs))], &
      [(any(anchors == (problem%boundary%prescribed_dofs(i) - 1) / problem%mesh%n_dim + 1), &
      i=1, size(problem%boundary%prescribed_dofs))])
    call impose_dirichlet_rows(basis, problem%boundary%prescribed_dofs(rows), problem%boundary%prescribed_values(rows, :), &
      problem%deck%reduction%rank_tolerance, cluster%basis, cluster%lifting, rank)
    misfit = prescribed_misfit(problem, snapshots, rows, cluster%lifting)
    if (misfit > representable) call make_error(error, 'the modes miss the prescribed displacements by ' // &
      to_text(misfit) // ' of their size', problem%deck%path, &
      hint='use reduction.dirichlet: elastic_lifting, or a smaller reduction.pod_tolerance')
  end subroutine split_prescribed

  !> Largest difference between the lifting and the prescribed values over the training points, relative to the values.
  !>
  !> Term by term the modes may miss them (both sides of a symmetric body move together): only their sum has to fit.
  real(rk) function prescribed_misfit(problem, snapshots, rows, lifting) result(misfit)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    !> which of the prescribed dofs
    integer, intent(in) :: rows(:)
    real(rk), intent(in) :: lifting(:, :)
    real(rk), allocatable :: theta(:, :), wanted(:, :), found(:, :)
    integer :: i_bad_point, i_bad_source

    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    wanted = matmul(problem%boundary%prescribed_values(rows, :), theta(:size(lifting, 2), :))
    found = matmul(lifting(problem%boundary%prescribed_dofs(rows), :), theta(:size(lifting, 2), :))
    misfit = maxval([0.0_rk, abs(found - wanted)])
    if (misfit > 0) misfit = misfit / max(tiny(misfit), maxval(abs(wanted)))
  end function prescribed_misfit

  !> sigma_max / sigma_min, huge where singular.
  real(rk) function condition_of(matrix) result(condition)
    real(rk), intent(in) :: matrix(:, :)
    real(rk), allocatable :: sigma(:)

    condition = 1
    if (size(matrix) == 0) return
    sigma = singular_values(matrix)
    condition = huge(condition)
    if (sigma(size(sigma)) > 0) condition = sigma(1) / sigma(size(sigma))
  end function condition_of

  !> Trap 1 of the method: modes that no force inside the domain drives cannot be determined.
  subroutine check_solvable(problem, cluster, stiffness_rank, error)
    type(problem_t), intent(in) :: problem
    type(reduced_model_t), intent(inout) :: cluster
    !> of K_r
    integer, intent(in) :: stiffness_rank
    type(error_t), allocatable, intent(out) :: error

    allocate (cluster%warnings(0))
    if (cluster%rank < cluster%n_rows) then
      call append_text(cluster%warnings, 'the solvability condition (11) fails: rank ' // to_text(cluster%rank) // ' of ' // &
        to_text(cluster%n_rows) // ' contact rows; multipliers may not be unique')
      call log_warning(cluster%warnings(1)%text)
    end if
    if (stiffness_rank == cluster%n_modes) return
    call make_error(error, 'the equations of the reduced integration domain determine ' // to_text(stiffness_rank) // &
      ' of ' // to_text(cluster%n_modes) // ' modes (its contact rows and loaded dofs allow ' // &
      to_text(cluster%primal_rank_expected) // ')', problem%deck%path, &
      hint='add the contact surfaces and the loaded surfaces to reduction.zones_of_interest, or raise reduction.pod_tolerance')
  end subroutine check_solvable

  !> What the reconstruction outside the domain is made of.
  subroutine keep_dual_snapshots(problem, snapshots, cluster)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(reduced_model_t), intent(inout) :: cluster

    cluster%dual_snapshots = snapshots%multipliers
    cluster%contact_displacement_snapshots = normal_displacements(problem%operator, snapshots%displacement)
    cluster%contact_value_basis = normal_displacements(problem%operator, cluster%basis)
    cluster%contact_value_lifting = normal_displacements(problem%operator, cluster%lifting)
  end subroutine keep_dual_snapshots

  !> Displacement along n of the first nodes, then of the second nodes.
  pure function normal_displacements(operator, fields) result(values)
    type(contact_operator_t), intent(in) :: operator
    !> [length] shape (n_dofs, n_fields)
    real(rk), intent(in) :: fields(:, :)
    !> [length] shape (2 * n_rows, n_fields)
    real(rk) :: values(2 * operator%n_rows, size(fields, 2))
    integer :: k, n

    n = operator%n_dim
    do k = 1, operator%n_rows
      associate (dofs => operator%dofs(:, k), normal => operator%coefficients(:n, k))
        values(k, :) = matmul(normal, fields(dofs(:n), :))
        values(operator%n_rows + k, :) = matmul(normal, fields(dofs(n + 1:), :))
      end associate
    end do
  end function normal_displacements
end module sig_training
