! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Times the clustering of the cells of a regular grid, in CPU time of the first rank.
!>
!> Arguments: snapshots.h5, number of clusters, energy tail of the cells' bases, points per parameter.
program benchmark_cells
  use sig_clustering, only: cell_subspaces, clusters_of_cells
  use sig_dissimilarity, only: dissimilarity_of_subspaces, snapshot_coordinates
  use sig_errors, only: error_report, error_t
  use sig_grassmann, only: subspace_t
  use sig_grid_cells, only: grid_cells_t
  use sig_k_medoids, only: find_medoids, k_medoids_options_t, medoids_t
  use sig_kinds, only: rk
  use sig_petsc_support, only: end_petsc, rows_of_rank, start_petsc
  use sig_snapshot_store, only: read_snapshot_set, snapshot_set_t
  use sig_training_set, only: take_snapshots, training_set_t
  use petsc
  implicit none(type, external)
  character(1024) :: argument
  type(error_t), allocatable :: error
  type(grid_cells_t) :: cells
  type(medoids_t) :: found
  type(snapshot_set_t), target :: set
  type(training_set_t) :: snapshots
  type(subspace_t), allocatable :: subspaces(:)
  real(rk), allocatable :: coordinates(:, :), dissimilarity(:, :)
  real(rk) :: pod_tolerance, times(5)
  integer :: dofs(2), i, n_clusters, rank
  PetscErrorCode :: ierr

  PetscCallA(start_petsc(ierr))
  call MPI_Comm_rank(PETSC_COMM_WORLD, rank, ierr)
  call get_command_argument(1, argument)
  call read_snapshot_set(trim(argument), '', set, error, [1, 0])
  if (allocated(error)) error stop error_report(error)
  PetscCallA(rows_of_rank(set%n_dofs, PETSC_COMM_WORLD, dofs(1), dofs(2), ierr))
  call read_snapshot_set(trim(argument), '', set, error, dofs)
  if (allocated(error)) error stop error_report(error)
  snapshots = take_snapshots(set, [(i, i=1, size(set%reasons))])
  call get_command_argument(2, argument)
  read (argument, *) n_clusters
  call get_command_argument(3, argument)
  read (argument, *) pod_tolerance
  allocate (cells%n_values(command_argument_count() - 3))
  do i = 1, size(cells%n_values)
    call get_command_argument(3 + i, argument)
    read (argument, *) cells%n_values(i)
  end do
  times(1) = processor_time()
  PetscCallA(snapshot_coordinates(snapshots, PETSC_COMM_WORLD, coordinates, ierr))
  times(2) = processor_time()
  subspaces = cell_subspaces(coordinates, cells, [(i, i=1, cells%n_cells())], pod_tolerance)
  times(3) = processor_time()
  PetscCallA(dissimilarity_of_subspaces(subspaces, PETSC_COMM_WORLD, dissimilarity, ierr))
  times(4) = processor_time()
  call find_medoids(dissimilarity, n_clusters, k_medoids_options_t(), found, error)
  times(5) = processor_time()
  if (allocated(error)) error stop error_report(error)
  if (rank == 0) then
    print '(i0, a)', cells%n_cells(), ' cells'
    print '(4(a, f6.3), a)', 'QR ', times(2) - times(1), ' s, bases ', times(3) - times(2), ' s, dissimilarities ', &
      times(4) - times(3), ' s, medoids ', times(5) - times(4), ' s'
    print '(a, *(1x, i0))', 'dimensions from and to:', minval([(size(subspaces(i)%basis, 2), i=1, size(subspaces))]), &
      maxval([(size(subspaces(i)%basis, 2), i=1, size(subspaces))])
    print '(a, g0.8, a, g0.4)', 'loss ', found%loss, ', silhouette ', found%silhouette
    associate (clusters => clusters_of_cells(found%labels, n_clusters, cells))
      print '(a, *(1x, i0))', 'snapshots in the clusters:', (size(clusters(i)%snapshots), i=1, n_clusters)
    end associate
  end if
  PetscCallA(end_petsc(ierr))

contains

  !> [s] of this rank's processor: a busy machine does not lengthen it.
  real(rk) function processor_time() result(seconds)
    call cpu_time(seconds)
  end function processor_time
end program benchmark_cells
