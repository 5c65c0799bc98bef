! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The discrete problem (3): K u + B' lambda = F, B u <= D, lambda >= 0, lambda' (D - B u) = 0, with prescribed displacements.
module sig_contact_system
  use sig_assembly, only: assemble_stiffness, fill_stiffness
  use sig_boundary_conditions, only: boundary_conditions_t
  use sig_clock, only: wall_time
  use sig_contact_laws, only: contact_laws_t, laws_without_friction
  use sig_contact_rows, only: contact_rows_t
  use sig_corner_means, only: corner_means_t, find_corner_means
  use sig_dof_map, only: create_dof_map, dof_map_t
  use sig_elastic_body, only: elastic_body_t
  use sig_kinds, only: rk
  use sig_mesh, only: mesh_partition_t, mesh_t
  use sig_mesh_partition, only: partition_mesh
  use sig_petsc_support, only: create_vector, rank_and_size, sum_over_ranks
  use sig_rigid_motions, only: create_rigid_motions, rigid_motions_t
  use petsc
  implicit none(type, external)
  private
  public :: contact_system_t

  !> The problem on the ranks of one communicator: call create, use it, call destroy.
  type :: contact_system_t
    MPI_Comm :: comm = MPI_COMM_NULL
    type(dof_map_t) :: map
    !> prescribed displacements, also 0 on the supports of the idle motions, and loads
    type(boundary_conditions_t) :: boundary
    !> rows with a multiplier: normal rows of all contacts, then tangential rows
    type(contact_rows_t) :: rows
    type(contact_laws_t) :: laws
    !> a solver gets so many states of a history at once, in their order, because later ones depend on earlier ones; 1 where nothing
    !> remembers
    integer :: n_times = 1
    !> bodies, and the rigid motions that no prescribed displacement holds
    type(rigid_motions_t) :: motions
    !> forces balance along the components from this one on: not along r in axisymmetry
    integer :: first_balanced = 1
    !> K on all dofs, Dirichlet rows included
    Mat :: stiffness
    !> [force/length] largest sum of the absolute values of a row of K
    real(rk) :: stiffness_size = 0
    !> [s] wall time of the partition of the mesh, of the assembly
    real(rk) :: partition_seconds = 0
    real(rk) :: assembly_seconds = 0
    !> of which corners each node of this rank (map%local_nodes) is the middle
    type(corner_means_t) :: corner_means
    !> two work vectors with the layout of K
    Vec :: work_in
    Vec :: work_out
  contains
    procedure :: create
    procedure :: update_stiffness
    procedure :: prescribed_displacement
    procedure :: gap
    procedure :: load
    procedure :: apply_stiffness
    procedure :: put
    procedure :: put_some
    procedure :: get
    procedure :: share_columns
    procedure :: leave_out_idle
    procedure :: destroy
  end type contact_system_t

contains

  !> Partitions the mesh over the ranks of comm, creates the problem and assembles K. Collective on comm.
  subroutine create(self, comm, mesh, body, boundary, rows, ierr, laws, n_times)
    class(contact_system_t), intent(out) :: self
    MPI_Comm, intent(in) :: comm
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    type(boundary_conditions_t), intent(in) :: boundary
    !> rows with a multiplier, no inert ones
    type(contact_rows_t), intent(in) :: rows
    PetscErrorCode, intent(out) :: ierr
    !> default: contacts without friction
    type(contact_laws_t), intent(in), optional :: laws
    !> number of times of a history; default: 1
    integer, intent(in), optional :: n_times
    type(mesh_partition_t) :: partition
    real(rk) :: start
    integer, allocatable :: tied_first(:), tied_second(:)
    integer :: rank, n_ranks

    self%comm = comm
    self%boundary = boundary
    self%rows = rows
    self%laws = laws_without_friction(rows%n_rows)
    if (present(laws)) self%laws = laws
    if (present(n_times) .and. self%laws%remembers()) self%n_times = n_times
    if (body%mechanics%is_round) self%first_balanced = 2
    start = wall_time()
    call rows%tied_nodes(mesh%n_nodes, tied_first, tied_second)
    PetscCall(partition_mesh(mesh, tied_first, tied_second, comm, partition, ierr))
    self%partition_seconds = wall_time() - start
    PetscCall(rank_and_size(comm, rank, n_ranks, ierr))
    call create_dof_map(mesh, partition, rank, n_ranks, self%map)
    call find_corner_means(mesh, self%map%local_nodes(), self%corner_means)
    call create_rigid_motions(mesh, body%mechanics%is_round, boundary%is_prescribed, rows, self%motions)
    call self%boundary%hold_dofs(self%motions%idle%supports)
    start = wall_time()
    PetscCall(assemble_stiffness(comm, mesh, body, self%map, self%stiffness, ierr))
    PetscCall(MatNorm(self%stiffness, NORM_INFINITY, self%stiffness_size, ierr))
    self%assembly_seconds = wall_time() - start
    PetscCall(create_vector(comm, self%map%n_local_dofs, self%work_in, ierr))
    PetscCall(create_vector(comm, self%map%n_local_dofs, self%work_out, ierr))
  end subroutine create

  !> Assembles K again with other materials on the same mesh, and sets stiffness_size, the largest sum of the absolute values of a
  !> row of K. Data that a solver derived from the old K are then out of date. Collective.
  subroutine update_stiffness(self, mesh, body, ierr)
    class(contact_system_t), intent(inout) :: self
    type(mesh_t), intent(in) :: mesh
    type(elastic_body_t), intent(in) :: body
    PetscErrorCode, intent(out) :: ierr

    PetscCall(MatZeroEntries(self%stiffness, ierr))
    PetscCall(fill_stiffness(mesh, body, self%map, self%stiffness, ierr))
    PetscCall(MatNorm(self%stiffness, NORM_INFINITY, self%stiffness_size, ierr))
  end subroutine update_stiffness

  !> Returns the displacement u_D(mu) on the prescribed dofs, 0 elsewhere. Local.
  pure function prescribed_displacement(self, theta) result(displacement)
    class(contact_system_t), intent(in) :: self
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [length] shape (n_dofs)
    real(rk) :: displacement(self%map%n_dofs)

    displacement = self%boundary%prescribed_displacement(theta)
  end function prescribed_displacement

  !> Returns the gaps D(mu). Local.
  pure function gap(self, theta)
    class(contact_system_t), intent(in) :: self
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [length] shape (n_rows)
    real(rk) :: gap(self%rows%n_rows)

    gap = matmul(self%rows%gap, theta)
  end function gap

  !> Returns the loads F(mu). Local.
  pure function load(self, theta)
    class(contact_system_t), intent(in) :: self
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    !> [force] natural, shape (n_dofs)
    real(rk) :: load(self%map%n_dofs)

    load = self%boundary%forces(theta)
  end function load

  !> Computes K u; both arrays are complete on every rank. Collective.
  subroutine apply_stiffness(self, displacement, forces, ierr)
    class(contact_system_t), intent(inout) :: self
    !> [length] natural, shape (n_dofs)
    real(rk), intent(in) :: displacement(:)
    !> [force] natural, shape (n_dofs)
    real(rk), intent(out) :: forces(:)
    PetscErrorCode, intent(out) :: ierr

    PetscCall(self%put(displacement, self%work_in, ierr))
    PetscCall(MatMult(self%stiffness, self%work_in, self%work_out, ierr))
    PetscCall(self%get(self%work_out, forces, ierr))
  end subroutine apply_stiffness

  !> Copies an array that every rank has into a distributed vector with the layout of K. Local.
  subroutine put(self, values, vector, ierr)
    class(contact_system_t), intent(in) :: self
    !> natural, shape (n_dofs)
    real(rk), intent(in) :: values(:)
    Vec, intent(inout) :: vector
    PetscErrorCode, intent(out) :: ierr
    PetscScalar, pointer :: local(:)

    PetscCall(VecGetArrayF90(vector, local, ierr))
    local = values(self%map%local_dofs)
    PetscCall(VecRestoreArrayF90(vector, local, ierr))
  end subroutine put

  !> Copies the values of some dofs into a distributed vector with the layout of K; other dofs keep their values. Local.
  subroutine put_some(self, dofs, values, vector, ierr)
    class(contact_system_t), intent(in) :: self
    !> chosen dofs, natural; those of other ranks are skipped
    integer, intent(in) :: dofs(:)
    !> natural, shape (n_dofs); read on `dofs` only
    real(rk), intent(in) :: values(:)
    Vec, intent(inout) :: vector
    PetscErrorCode, intent(out) :: ierr
    PetscScalar, pointer :: local(:)
    integer :: i, i_local

    PetscCall(VecGetArrayF90(vector, local, ierr))
    do i = 1, size(dofs)
      i_local = self%map%local_index(dofs(i))
      if (i_local > 0) local(i_local) = values(dofs(i))
    end do
    PetscCall(VecRestoreArrayF90(vector, local, ierr))
  end subroutine put_some

  !> Copies a distributed vector with the layout of K into an array on every rank. Collective.
  subroutine get(self, vector, values, ierr)
    class(contact_system_t), intent(in) :: self
    Vec, intent(in) :: vector
    !> natural, shape (n_dofs)
    real(rk), intent(out) :: values(:)
    PetscErrorCode, intent(out) :: ierr
    PetscScalar, pointer :: local(:)

    values = 0
    PetscCall(VecGetArrayReadF90(vector, local, ierr))
    values(self%map%local_dofs) = local
    PetscCall(VecRestoreArrayReadF90(vector, local, ierr))
    PetscCall(sum_over_ranks(self%comm, values, ierr))
  end subroutine get

  !> Copies distributed columns into an array on every rank. If `local` has fewer than n_columns columns, the last columns of the
  !> result are zeros. Collective.
  subroutine share_columns(self, local, n_columns, columns, ierr)
    class(contact_system_t), intent(in) :: self
    !> values at the dofs of this rank (map%local_dofs), shape (n_local_dofs, n); n is at most n_columns and the same on all ranks
    real(rk), intent(in) :: local(:, :)
    !> number of columns of the result
    integer, intent(in) :: n_columns
    !> natural, shape (n_dofs, n_columns)
    real(rk), allocatable, intent(out) :: columns(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: i

    ierr = 0
    allocate (columns(self%map%n_dofs, n_columns), source=0.0_rk)
    do i = 1, size(local, 2)
      columns(self%map%local_dofs, i) = local(:, i)
      PetscCall(sum_over_ranks(self%comm, columns(:, i), ierr))
    end do
  end subroutine share_columns

  !> Takes the idle motions out of responses of K, in which the supports of these motions are held. Collective.
  subroutine leave_out_idle(self, columns, ierr)
    class(contact_system_t), intent(in) :: self
    !> [length] rows of this rank, shape (n_local_dofs, n_columns)
    real(rk), intent(inout) :: columns(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: nodes(:)
    real(rk), allocatable :: shares(:, :)

    ierr = 0
    associate (idle => self%motions%idle)
      if (idle%n == 0) return
      nodes = self%map%local_dofs(self%map%n_dim::self%map%n_dim) / self%map%n_dim
      shares = idle%shares_of_carriers(self%motions, nodes, columns)
      PetscCall(sum_over_ranks(self%comm, shares, ierr))
      call idle%take_from_carriers(self%motions, nodes, shares, columns)
    end associate
  end subroutine leave_out_idle

  !> Frees K and the work vectors. Collective.
  subroutine destroy(self, ierr)
    class(contact_system_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    PetscCall(MatDestroy(self%stiffness, ierr))
    PetscCall(VecDestroy(self%work_in, ierr))
    PetscCall(VecDestroy(self%work_out, ierr))
  end subroutine destroy
end module sig_contact_system
