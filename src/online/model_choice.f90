! SPDX-License-Identifier: BSD-3-Clause
!> Chooses the cluster that answers at a point: by the grid cell or by a random forest.
module sig_model_choice
  use sig_errors, only: error_t
  use sig_forest, only: forest_t
  use sig_grid_cells, only: grid_cells_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: model_choice_t

  !> The choice is by cell where there are labels, and by forest where there is one; otherwise there is one cluster.
  type :: model_choice_t
    !> cells of the training grid
    type(grid_cells_t) :: cells
    !> cluster of each cell, 1-based; unallocated without cells
    integer, allocatable :: labels(:)
    !> random forest; its shares are unallocated where there is none
    type(forest_t) :: forest
    !> [rad] sum of the dissimilarities to the medoids, and [-] mean silhouette of the clustering
    real(rk) :: loss = 0
    real(rk) :: silhouette = 0
  contains
    procedure :: cluster_of
    procedure :: next_cluster
    procedure :: fits
    procedure :: read => read_choice
    procedure :: write => write_choice
  end type model_choice_t

contains

  !> Returns the number of the cluster that the choice selects at a point, 1-based; 1 if the choice is empty.
  integer function cluster_of(self, point)
    class(model_choice_t), intent(in) :: self
    !> [unit of each parameter] shape (n_parameters)
    real(rk), intent(in) :: point(:)
    integer :: second

    cluster_of = 1
    if (allocated(self%labels)) then
      cluster_of = self%labels(self%cells%find(point))
    else if (allocated(self%forest%shares)) then
      call self%forest%choose(point, cluster_of, second)
    end if
  end function cluster_of

  !> Returns the second choice at a point, 1-based; 0 if the choice knows one cluster only or is empty. A choice by cells gives the
  !> cluster of the nearest cell that belongs to another cluster than the first choice (of equally near cells, the lowest number). A
  !> forest gives the cluster with the second largest share.
  integer function next_cluster(self, point)
    class(model_choice_t), intent(in) :: self
    !> [unit of each parameter] shape (n_parameters)
    real(rk), intent(in) :: point(:)
    real(rk) :: distance, least
    integer :: best, i

    next_cluster = 0
    if (allocated(self%labels)) then
      best = self%cluster_of(point)
      least = huge(least)
      do i = 1, size(self%labels)
        if (self%labels(i) == best) cycle
        distance = self%cells%squared_distance(i, point)
        if (distance >= least) cycle
        least = distance
        next_cluster = self%labels(i)
      end do
    else if (allocated(self%forest%shares)) then
      call self%forest%choose(point, best, next_cluster)
    end if
  end function next_cluster

  !> Whether the choice fits a model with these numbers: a grid of n_parameters parameters with one label per cell, an existing
  !> cluster, or a forest of exactly n_clusters clusters and n_parameters parameters. An empty choice fits one cluster.
  pure logical function fits(self, n_clusters, n_parameters)
    class(model_choice_t), intent(in) :: self
    integer, intent(in) :: n_clusters
    integer, intent(in) :: n_parameters

    if (allocated(self%labels)) then
      fits = size(self%cells%n_values) == n_parameters .and. all(self%cells%n_values >= 1)
      ! checked before the product of integers, which could overflow
      if (fits) fits = product(real(max(1, self%cells%n_values - 1), rk)) <= size(self%labels)
      if (fits) fits = size(self%labels) == self%cells%n_cells()
      if (fits) fits = all(self%labels >= 1 .and. self%labels <= n_clusters)
    else if (allocated(self%forest%shares)) then
      fits = self%forest%n_clusters() == n_clusters .and. size(self%forest%parameter_names) == n_parameters
    else
      fits = n_clusters == 1
    end if
  end function fits

  !> Reads the choice from the group /choice; it stays empty if the file has no such group. Errors: a dataset or attribute is
  !> missing, or has another type or rank; the arrays of a forest do not fit together.
  subroutine read_choice(self, file, path, box, error)
    class(model_choice_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    !> name of the file for messages
    character(*), intent(in) :: path
    !> box of the model, shape (2, n_parameters)
    real(rk), intent(in) :: box(:, :)
    type(error_t), allocatable, intent(inout) :: error

    if (file%has('/choice/cells')) then
      call file%read('/choice/cells/n_values', self%cells%n_values, error)
      call file%read('/choice/cells/clusters', self%labels, error)
      self%cells%box = box
    else if (file%has('/choice/forest')) then
      call self%forest%read(file, '/choice/forest', path, error)
    end if
    if (.not. file%has('/choice')) return
    call file%read('/choice@loss', self%loss, error)
    call file%read('/choice@silhouette', self%silhouette, error)
  end subroutine read_choice

  !> Writes the choice to the group /choice; nothing if it is empty. A failure of the file is reported when the file is closed.
  subroutine write_choice(self, file)
    class(model_choice_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file

    if (allocated(self%labels)) then
      call file%write('/choice/cells/n_values', self%cells%n_values, description='points of the grid along each parameter')
      call file%write('/choice/cells/clusters', self%labels, description='cluster of each cell, 1-based, last parameter fastest')
    else if (allocated(self%forest%shares)) then
      call self%forest%write(file, '/choice/forest')
    else
      return
    end if
    call file%write('/choice@loss', self%loss)
    call file%write('/choice@silhouette', self%silhouette)
  end subroutine write_choice
end module sig_model_choice
