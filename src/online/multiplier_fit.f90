! SPDX-License-Identifier: BSD-3-Clause
!> Computes the multipliers of all contacts from those of the reduced integration domain: the non-negative combination of the dual
!> snapshots that is nearest to the known values of an answer.
!>
!> The known values are the multipliers of the domain and, unless the model leaves them out, the normal displacements of all contact
!> nodes. Each of these two blocks is divided by the size of its snapshots, so that units do not matter. The resultants on bodies
!> that only contact holds are known exactly, so the forces are replaced by the nearest forces that balance the loads. In models
!> with a certificate without W, only the openings of combinations are known: there the coefficients of the combination and the
!> forces of the domain are replaced instead.
module sig_multiplier_fit
  use sig_force_balance, only: balance_loaded_forces
  use sig_kinds, only: rk
  use sig_linear_algebra, only: multiply
  use sig_hhr_data, only: add_lifted, fill_openings, hhr_data_t
  use sig_nnls, only: nnls_t, nnls_workspace_t
  use sig_rounding, only: rounding
  implicit none(type, external)
  private
  public :: work_of_loads, multiplier_fit_t, multiplier_fit_workspace_t

  !> The parts of the fit that do not depend on the point.
  type :: multiplier_fit_t
    private
    type(nnls_t) :: snapshots
    integer :: n_rows = 0
    !> [-] number of normal displacements that are fitted, too
    integer :: n_values = 0
    integer :: n_snapshots = 0
    !> scales of the two blocks, [1/force] and [1/length]
    real(rk) :: multiplier_scale = 1
    real(rk) :: displacement_scale = 1
    !> whether the forces have to stay a combination of the snapshots
    logical :: is_bound_to_snapshots = .false.
    !> whether contacts outside of the domain that are open by the reduced displacement get no force
    logical :: releases_open_contacts = .false.
    !> [force] Euclidean norm of each snapshot's forces outside of the domain (1 if they are zero), shape (n_snapshots), and [-] the
    !> work of these forces on each rigid motion over this norm, shape (n_snapshots, n_motions)
    real(rk), allocatable :: outside_size(:)
    real(rk), allocatable :: outside_work(:, :)
  contains
    procedure :: prepare
    procedure :: evaluate
    procedure, private :: combine
    procedure, private :: release
    procedure, private :: balance
  end type multiplier_fit_t

  !> Work arrays of one thread. While the same cluster answers, nothing is allocated after the first point.
  type :: multiplier_fit_workspace_t
    type(nnls_workspace_t), private :: nnls
    !> shape (n_rows + n_values)
    real(rk), allocatable, private :: known(:)
    !> [-] coefficients of the combination, >= 0, shape (n_snapshots)
    real(rk), allocatable :: coefficients(:)
    !> [force] forces of the domain, shape (n_rows)
    real(rk), allocatable, private :: forces(:)
    !> [length] openings of all contacts, shape (n_multipliers)
    real(rk), allocatable, private :: opening(:)
  end type multiplier_fit_workspace_t

contains

  !> Computes from the snapshots of a cluster what does not depend on the point. There are no errors.
  subroutine prepare(self, cluster)
    class(multiplier_fit_t), intent(inout) :: self
    type(hhr_data_t), intent(in) :: cluster
    real(rk), allocatable :: known(:, :)

    self%n_rows = cluster%n_rows
    self%n_values = merge(size(cluster%contact_displacement_snapshots, 1), 0, cluster%fits_displacements)
    self%n_snapshots = size(cluster%dual_snapshots, 2)
    allocate (known(self%n_rows + self%n_values, self%n_snapshots))
    known(:self%n_rows, :) = cluster%dual_snapshots(cluster%contact_rows, :)
    self%multiplier_scale = inverse_size(known(:self%n_rows, :))
    known(:self%n_rows, :) = self%multiplier_scale * known(:self%n_rows, :)
    self%displacement_scale = inverse_size(cluster%contact_displacement_snapshots)
    self%releases_open_contacts = size(cluster%contact_displacement_snapshots) > 0 .and. &
      size(cluster%motion_load, 2) == 0 .and. .not. cluster%certificate%is_there()
    if (self%n_values > 0) then
      known(self%n_rows + 1:, :) = self%displacement_scale * cluster%contact_displacement_snapshots
    end if
    call self%snapshots%prepare(known)
    self%is_bound_to_snapshots = cluster%certificate%is_there() .and. size(cluster%motion_load, 2) > 0
    if (self%is_bound_to_snapshots) call measure_outside(self, cluster)
  end subroutine prepare

  !> Computes outside_size and outside_work, which `balance` needs.
  subroutine measure_outside(self, cluster)
    class(multiplier_fit_t), intent(inout) :: self
    type(hhr_data_t), intent(in) :: cluster
    real(rk) :: outside(size(cluster%dual_snapshots, 1), size(cluster%dual_snapshots, 2))
    integer :: i

    outside = cluster%dual_snapshots
    outside(cluster%contact_rows, :) = 0
    self%outside_size = [(norm2(outside(:, i)), i=1, self%n_snapshots)]
    where (.not. self%outside_size > 0) self%outside_size = 1
    self%outside_work = matmul(transpose(outside), cluster%motion_closing) / &
      spread(self%outside_size, 2, size(cluster%motion_closing, 2))
  end subroutine measure_outside

  !> Computes the multipliers of all contacts: those of the domain stay as they are, and the others are those of the combination of
  !> snapshots that fits best. If no row of the domain has a force, the others have none either. Others that are open by the reduced
  !> displacement get no force (release). They keep it in models with bodies that only contact holds, with a certificate of their
  !> own, or without displacements of the snapshots or gaps of all contacts. If only contact holds a body, all forces (in a model
  !> with a certificate of its own, the coefficients of the combination and the forces of the domain) are then replaced by the
  !> nearest ones that balance the loads (balance_loaded_forces), or stay if there are none. The coefficients are in `workspace`
  !> afterwards.
  subroutine evaluate(self, cluster, theta, coordinates, multipliers_rid, workspace, multipliers)
    class(multiplier_fit_t), intent(in) :: self
    !> the data that prepare was called with
    type(hhr_data_t), intent(in) :: cluster
    !> values of the model's terms, shape (n_terms)
    real(rk), contiguous, intent(in) :: theta(:)
    !> [length] gamma, shape (n_modes)
    real(rk), contiguous, intent(in) :: coordinates(:)
    !> [force] of the domain, >= 0, shape (n_rows)
    real(rk), intent(in) :: multipliers_rid(:)
    !> work arrays, allocated here where their sizes do not fit
    type(multiplier_fit_workspace_t), intent(inout) :: workspace
    !> [force] >= 0, shape (n_multipliers)
    real(rk), intent(out) :: multipliers(:)
    real(rk) :: residual_norm
    logical :: is_balanced
    integer :: i

    call reserve(self, size(multipliers), workspace)
    workspace%coefficients = 0
    workspace%forces(:) = multipliers_rid
    if (any(multipliers_rid > 0) .and. self%n_rows < size(multipliers)) then
      workspace%known(:self%n_rows) = self%multiplier_scale * multipliers_rid
      if (self%n_values > 0) then
        associate (displacements => workspace%known(self%n_rows + 1:))
          call multiply(self%displacement_scale, cluster%contact_value_basis, coordinates, 0.0_rk, displacements)
          call add_lifted(cluster, self%displacement_scale, cluster%contact_value_lifting, theta, displacements)
        end associate
      end if
      call self%snapshots%solve(workspace%known, workspace%nnls, workspace%coefficients, residual_norm)
    end if
    if (self%is_bound_to_snapshots) call self%balance(cluster, theta, workspace%coefficients, workspace%forces)
    call self%combine(cluster, workspace%coefficients, multipliers)
    if (self%releases_open_contacts) call self%release(cluster, theta, coordinates, workspace%opening, multipliers)
    do i = 1, self%n_rows
      multipliers(cluster%contact_rows(i)) = workspace%forces(i)
    end do
    if (size(cluster%motion_load, 2) > 0 .and. .not. self%is_bound_to_snapshots) &
      call balance_loaded_forces(cluster%motion_closing, work_of_loads(cluster, theta), multipliers, is_balanced)
  end subroutine evaluate

  !> Computes the forces of the combination on all contacts, those of the domain, too: the sum of the snapshots' forces, each times
  !> its coefficient.
  subroutine combine(self, cluster, coefficients, multipliers)
    class(multiplier_fit_t), intent(in) :: self
    type(hhr_data_t), intent(in) :: cluster
    !> [-] >= 0, shape (n_snapshots)
    real(rk), intent(in) :: coefficients(:)
    !> [force] shape (n_multipliers)
    real(rk), intent(out) :: multipliers(:)
    integer :: i

    multipliers = 0
    do i = 1, self%n_snapshots
      if (coefficients(i) > 0) multipliers = multipliers + coefficients(i) * cluster%dual_snapshots(:, i)
    end do
  end subroutine combine

  !> Sets the forces of a combination to zero at contacts that are open according to the reduced displacement. It does nothing if
  !> the model lacks the data for openings (fill_openings).
  !>
  !> A contact with a force l and an opening w > 0 breaks the condition l w = 0. The pairs (l, 0) and (0, w) meet it. In the norm of
  !> the fit, (a l)^2 + (b w)^2 with the scales a and b of its two blocks, (0, w) is the nearer one where a l <= b w. The values on
  !> the rows of the domain do not matter, because `evaluate` replaces them. Paper: all forces of the combination stay.
  subroutine release(self, cluster, theta, coordinates, opening, multipliers)
    class(multiplier_fit_t), intent(in) :: self
    type(hhr_data_t), intent(in) :: cluster
    real(rk), contiguous, intent(in) :: theta(:)
    real(rk), contiguous, intent(in) :: coordinates(:)
    !> [length] work array, shape (n_multipliers)
    real(rk), contiguous, intent(inout) :: opening(:)
    !> [force] of all contacts, shape (n_multipliers)
    real(rk), intent(inout) :: multipliers(:)
    logical :: is_known

    call fill_openings(cluster, theta, coordinates, opening, is_known)
    if (.not. is_known) return
    where (self%multiplier_scale * multipliers <= self%displacement_scale * opening) multipliers = 0
  end subroutine release

  !> Replaces the coefficients of the combination and the forces of the domain by the nearest ones that balance the loads, and keeps
  !> zeros if it can (balance_loaded_forces). In this distance a coefficient counts times the outside_size of its snapshot. Both
  !> stay unchanged if there are no such values.
  subroutine balance(self, cluster, theta, coefficients, forces)
    class(multiplier_fit_t), intent(in) :: self
    type(hhr_data_t), intent(in) :: cluster
    real(rk), intent(in) :: theta(:)
    !> [-] >= 0, shape (n_snapshots)
    real(rk), intent(inout) :: coefficients(:)
    !> [force] of the domain, shape (n_rows)
    real(rk), intent(inout) :: forces(:)
    real(rk) :: parts(self%n_snapshots + self%n_rows), work(size(parts), size(cluster%motion_load, 2))
    logical :: is_balanced
    integer :: i

    associate (m => self%n_snapshots)
      parts(:m) = coefficients * self%outside_size
      parts(m + 1:) = forces
      work(:m, :) = self%outside_work
      do i = 1, self%n_rows
        work(m + i, :) = cluster%motion_closing(cluster%contact_rows(i), :)
      end do
      call balance_loaded_forces(work, work_of_loads(cluster, theta), parts, is_balanced)
      if (.not. is_balanced) return
      coefficients = parts(:m) / self%outside_size
      forces = parts(m + 1:)
    end associate
  end subroutine balance

  !> Returns the work of the loads on each rigid motion that only contact holds, shape (n_motions), [force]: a motion is a
  !> displacement without unit. The work is 0 where the loads are in equilibrium except for rounding.
  pure function work_of_loads(cluster, theta) result(work)
    type(hhr_data_t), intent(in) :: cluster
    !> values of the model's terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    real(rk) :: work(size(cluster%motion_load, 2))
    integer :: i

    do i = 1, size(work)
      associate (parts => cluster%motion_load(:, i))
        work(i) = sum(parts * theta)
        if (abs(work(i)) <= rounding * sum(abs(parts * theta))) work(i) = 0
      end associate
    end do
  end function work_of_loads

  !> Allocates `known`, `coefficients`, `forces` and `opening` of the workspace again, unless all four have the right sizes already.
  !> It gives them no values.
  subroutine reserve(self, n_multipliers, workspace)
    class(multiplier_fit_t), intent(in) :: self
    !> number of contacts of the model
    integer, intent(in) :: n_multipliers
    type(multiplier_fit_workspace_t), intent(inout) :: workspace

    if (allocated(workspace%known)) then
      if (size(workspace%known) == self%n_rows + self%n_values .and. size(workspace%coefficients) == self%n_snapshots .and. &
        size(workspace%forces) == self%n_rows .and. size(workspace%opening) == n_multipliers) return
      deallocate (workspace%known, workspace%coefficients, workspace%forces, workspace%opening)
    end if
    allocate (workspace%known(self%n_rows + self%n_values), workspace%coefficients(self%n_snapshots))
    allocate (workspace%forces(self%n_rows), workspace%opening(n_multipliers))
  end subroutine reserve

  !> Returns 1 / Frobenius norm of a matrix; 1 for a matrix of zeros or without elements.
  pure function inverse_size(block) result(scale)
    real(rk), intent(in) :: block(:, :)
    real(rk) :: scale

    scale = norm2(block)
    scale = merge(1 / max(scale, tiny(scale)), 1.0_rk, scale > 0)
  end function inverse_size
end module sig_multiplier_fit
