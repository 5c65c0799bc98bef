! SPDX-License-Identifier: BSD-3-Clause
!> The reduced system of a domain and its modes: prescribed values split off, everything projected, solvability measured.
module sig_training_system
  use sig_condition_number, only: condition_number
  use sig_dirichlet_rows, only: impose_dirichlet_rows
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_log, only: log_warning
  use sig_model, only: reduced_model_t
  use sig_problem, only: problem_t
  use sig_projection, only: expected_stiffness_rank, project, project_contact_rows, projected_blocks_t
  use sig_reduced_domain, only: reduced_domain_t
  use sig_snapshot_store, only: snapshot_set_t
  use sig_term_values, only: evaluate_points
  use sig_text, only: append_text, to_text
  implicit none(type, external)
  private
  public :: build_system

contains

  !> Projects, and measures what makes the reduced problem solvable: kappa, the rank of (11), cond(K_r), the rank of trap 1.
  subroutine build_system(problem, snapshots, domain, anchors, modes, cluster, error)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    type(reduced_domain_t), intent(in) :: domain
    integer, intent(in) :: anchors(:)
    !> V, shape (n_dofs, n_modes)
    real(rk), intent(in) :: modes(:, :)
    type(reduced_model_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(out) :: error
    type(projected_blocks_t) :: blocks

    call condition_number(project_contact_rows(problem%operator, domain, modes), problem%deck%reduction%rank_tolerance, &
      cluster%condition_number, cluster%rank)
    call split_prescribed(problem, snapshots, anchors, modes, cluster, error)
    if (allocated(error)) return
    call project(problem%mesh, problem%body, problem%operator, problem%boundary%loads, domain, cluster%basis, &
      cluster%lifting, blocks)
    call keep_domain(domain, cluster)
    call keep_blocks(blocks, cluster)
    cluster%primal_rank_expected = expected_stiffness_rank(domain, &
      problem%boundary%loads%loaded_dofs(size(modes, 1)), cluster%n_modes)
    call check_solvable(problem, cluster, error)
  end subroutine build_system

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

  subroutine keep_blocks(blocks, cluster)
    type(projected_blocks_t), intent(in) :: blocks
    type(reduced_model_t), intent(inout) :: cluster

    cluster%n_modes = size(blocks%reduced_stiffness, 1)
    cluster%reduced_stiffness = blocks%reduced_stiffness
    cluster%contact_matrix = blocks%contact_matrix
    cluster%load = blocks%load
    cluster%gap = blocks%gap
  end subroutine keep_blocks

  !> Displacement = lifting * theta + basis * gamma, either way of treating the prescribed values.
  subroutine split_prescribed(problem, snapshots, anchors, modes, cluster, error)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    integer, intent(in) :: anchors(:)
    real(rk), intent(in) :: modes(:, :)
    type(reduced_model_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(out) :: error
    !> [-] prescribed values that the modes miss by more than this cannot be imposed
    real(rk), parameter :: representable = 1.0e-6_rk
    integer, allocatable :: rows(:)
    real(rk) :: misfit
    integer :: rank, i

    if (problem%deck%reduction%dirichlet /= 'multiplier') then
      cluster%basis = modes
      cluster%lifting = snapshots%free_response
      return
    end if
    rows = pack([(i, i=1, size(problem%boundary%prescribed_dofs))], &
      [(any(anchors == (problem%boundary%prescribed_dofs(i) - 1) / problem%mesh%n_dim + 1), &
      i=1, size(problem%boundary%prescribed_dofs))])
    call impose_dirichlet_rows(modes, problem%boundary%prescribed_dofs(rows), problem%boundary%prescribed_values(rows, :), &
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

  !> Trap 1 of the method: modes that no force inside the domain drives cannot be determined.
  subroutine check_solvable(problem, cluster, error)
    type(problem_t), intent(in) :: problem
    type(reduced_model_t), intent(inout) :: cluster
    type(error_t), allocatable, intent(out) :: error
    real(rk) :: condition
    integer :: stiffness_rank, rank

    allocate (cluster%warnings(0))
    if (cluster%rank < cluster%n_rows) then
      call append_text(cluster%warnings, 'the solvability condition (11) fails: rank ' // to_text(cluster%rank) // ' of ' // &
        to_text(cluster%n_rows) // ' contact rows; multipliers may not be unique')
      call log_warning(cluster%warnings(1)%text)
    end if
    call condition_number(cluster%reduced_stiffness, 0.0_rk, cluster%stiffness_condition, rank)
    call condition_number(cluster%reduced_stiffness, problem%deck%reduction%rank_tolerance, condition, stiffness_rank)
    if (stiffness_rank == cluster%n_modes) return
    call make_error(error, 'the equations of the reduced integration domain determine ' // to_text(stiffness_rank) // &
      ' of ' // to_text(cluster%n_modes) // ' modes (its contact rows and loaded dofs allow ' // &
      to_text(cluster%primal_rank_expected) // ')', problem%deck%path, &
      hint='add the contact surfaces and the loaded surfaces to reduction.zones_of_interest, or raise reduction.pod_tolerance')
  end subroutine check_solvable
end module sig_training_system
