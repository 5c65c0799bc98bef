! SPDX-License-Identifier: BSD-3-Clause
!> A random forest that scikit-learn trained (signorom-post forest): it gives the cluster of a point. forest.c walks the trees.
module sig_forest
  use, intrinsic :: iso_c_binding, only: c_double, c_int, c_loc, c_ptr
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use sig_errors, only: error_t, make_error
  use sig_hdf5_format, only: check_format, file_format_t
  use sig_hdf5_reader, only: h5_reader_t
  use sig_hdf5_writer, only: h5_writer_t
  use sig_kinds, only: rk
  use sig_text, only: join, string_t, to_text
  implicit none(type, external)
  private
  public :: forest_t, read_forest

  type(file_format_t), parameter :: forest_format = &
    file_format_t('signorom forest', 2, 2, 'signorom-post forest LABELS.csv writes one')

  !> A forest: the nodes of all trees stand one after the other. Numbers are 0-based as in forest.h.
  type :: forest_t
    !> names of the parameters in the order of the features
    type(string_t), allocatable :: parameter_names(:)
    !> [unit of each parameter] smallest and largest values of the points with which the forest was trained, shape (n_parameters).
    !> Features are parameters from 0 to 1 between them, because scikit-learn takes values that differ by less than 1e-7 as equal
    real(rk), allocatable :: lowest(:), highest(:)
    !> first node of each tree, and at the end the number of all nodes, shape (n_trees + 1)
    integer, allocatable :: tree_starts(:)
    !> feature that a node compares, -1 in a leaf, shape (n_nodes)
    integer, allocatable :: feature(:)
    !> [-] a feature up to the threshold goes to the left child, shape (n_nodes)
    real(rk), allocatable :: threshold(:)
    !> children of each node, counted from the first node of its tree, shape (n_nodes)
    integer, allocatable :: left(:)
    integer, allocatable :: right(:)
    !> [-] share of each cluster among the training points in a node, shape (n_clusters, n_nodes); only those of leaves are used
    real(rk), allocatable :: shares(:, :)
  contains
    procedure :: n_clusters
    procedure :: votes
    procedure :: choose
    procedure :: read => read_arrays
    procedure :: write => write_arrays
    procedure, private :: arrays
    procedure, private :: features
  end type forest_t

  !> The structure sig_forest of forest.h; its pointers refer to arrays of a forest_t.
  type, bind(c) :: forest_arrays_t
    integer(c_int) :: n_features
    integer(c_int) :: n_classes
    integer(c_int) :: n_trees
    type(c_ptr) :: tree_starts
    type(c_ptr) :: feature
    type(c_ptr) :: threshold
    type(c_ptr) :: left
    type(c_ptr) :: right
    type(c_ptr) :: values
  end type forest_arrays_t

  interface
    integer(c_int) function sig_forest_check(forest) bind(c)
      import :: c_int, forest_arrays_t
      implicit none(type, external)
      type(forest_arrays_t), intent(in) :: forest
    end function sig_forest_check

    subroutine sig_forest_votes(forest, point, votes) bind(c)
      import :: c_double, forest_arrays_t
      implicit none(type, external)
      type(forest_arrays_t), intent(in) :: forest
      real(c_double), intent(in) :: point(*)
      real(c_double), intent(out) :: votes(*)
    end subroutine sig_forest_votes
  end interface

contains

  !> Returns the number of clusters that the forest chooses from.
  pure integer function n_clusters(self)
    class(forest_t), intent(in) :: self

    n_clusters = size(self%shares, 1)
  end function n_clusters

  !> Returns the C structure of the forest. It points into self, which therefore has to be a target in the caller, too.
  type(forest_arrays_t) function arrays(self)
    class(forest_t), intent(in), target :: self

    arrays = forest_arrays_t(size(self%parameter_names), size(self%shares, 1), size(self%tree_starts) - 1, &
      c_loc(self%tree_starts), c_loc(self%feature), c_loc(self%threshold), c_loc(self%left), c_loc(self%right), &
      c_loc(self%shares))
  end function arrays

  !> [-] Returns the features of a point; that of a parameter with one value in all training points is 0.
  pure function features(self, point)
    class(forest_t), intent(in) :: self
    !> [unit of each parameter] shape (n_parameters)
    real(rk), intent(in) :: point(:)
    real(rk) :: features(size(point))

    features = 0
    where (self%highest > self%lowest) features = (point - self%lowest) / (self%highest - self%lowest)
  end function features

  !> Returns the share of each cluster in the leaf of the point, as a mean over all trees. The features are rounded to single
  !> precision, as scikit-learn does.
  function votes(self, point) result(shares)
    class(forest_t), intent(in), target :: self
    !> [unit of each parameter] shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> [-] shape (n_clusters)
    real(rk), allocatable :: shares(:)

    allocate (shares(self%n_clusters()))
    call sig_forest_votes(self%arrays(), self%features(point), shares)
  end function votes

  !> Finds the cluster with the largest mean share (votes) and the one with the second largest. Of equal shares, the lower number
  !> counts.
  subroutine choose(self, point, best, second)
    class(forest_t), intent(in), target :: self
    !> [unit of each parameter] shape (n_parameters)
    real(rk), intent(in) :: point(:)
    !> 1-based
    integer, intent(out) :: best
    !> 1-based; 0 where there is one cluster only
    integer, intent(out) :: second
    real(rk) :: shares(size(self%shares, 1))

    call sig_forest_votes(self%arrays(), self%features(point), shares)
    best = maxloc(shares, dim=1)
    shares(best) = -1
    second = 0
    if (size(shares) > 1) second = maxloc(shares, dim=1)
  end subroutine choose

  !> Reads the file that signorom-post forest writes. Errors: the file cannot be read, has another format or version; those of
  !> read_arrays; its parameters are not those of the model, or are in another order.
  subroutine read_forest(path, parameter_names, forest, error)
    character(*), intent(in) :: path
    !> parameters of the model, in its order
    type(string_t), intent(in) :: parameter_names(:)
    type(forest_t), intent(out) :: forest
    type(error_t), allocatable, intent(out) :: error
    type(h5_reader_t) :: file
    integer :: version

    call file%open(path, error)
    if (allocated(error)) return
    call check_format(file, path, forest_format, version, error)
    call forest%read(file, '', path, error)
    call file%close()
    if (allocated(error)) return
    if (join(forest%parameter_names, ', ') /= join(parameter_names, ', ')) call make_error(error, &
      'the forest was trained for the parameters ' // join(forest%parameter_names, ', ') // '; the model has ' // &
      join(parameter_names, ', '), path, hint='names and order must be the same; signorom train makes this file again')
  end subroutine read_forest

  !> Reads the forest from a group of an open file. Errors: an array is missing, has another type or rank, does not fit the others
  !> or is not finite, or the arrays do not form trees.
  subroutine read_arrays(self, file, group, path, error)
    class(forest_t), intent(inout) :: self
    type(h5_reader_t), intent(in) :: file
    !> without its last slash; empty = the root
    character(*), intent(in) :: group
    !> name of the file for the message
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(inout) :: error

    call file%read(group // '/parameter_names', self%parameter_names, error)
    call file%read(group // '/lowest', self%lowest, error)
    call file%read(group // '/highest', self%highest, error)
    call file%read(group // '/tree_starts', self%tree_starts, error)
    call file%read(group // '/feature', self%feature, error)
    call file%read(group // '/threshold', self%threshold, error)
    call file%read(group // '/left', self%left, error)
    call file%read(group // '/right', self%right, error)
    call file%read(group // '/shares', self%shares, error)
    if (allocated(error)) return
    if (.not. is_sound(self)) call make_error(error, 'the random forest in the file is damaged: its trees are inconsistent', &
      path, hint='signorom train makes this file again, forest.h5 as well as a model')
  end subroutine read_arrays

  !> Whether the arrays fit together, are finite and form trees.
  logical function is_sound(forest)
    class(forest_t), intent(in), target :: forest
    integer :: n_nodes

    n_nodes = size(forest%feature)
    is_sound = all([size(forest%lowest), size(forest%highest)] == size(forest%parameter_names))
    if (is_sound) is_sound = all(ieee_is_finite(forest%lowest)) .and. all(ieee_is_finite(forest%highest))
    if (is_sound) is_sound = size(forest%tree_starts) > 1
    if (is_sound) is_sound = all([size(forest%threshold), size(forest%left), size(forest%right), size(forest%shares, 2)] == n_nodes)
    if (is_sound) is_sound = forest%tree_starts(size(forest%tree_starts)) == n_nodes .and. all(ieee_is_finite(forest%threshold)) &
      .and. all(ieee_is_finite(forest%shares))
    if (is_sound) is_sound = sig_forest_check(forest%arrays()) == 0
  end function is_sound

  !> Writes the forest to a group of an open file. A failure of the file is reported when the file is closed.
  subroutine write_arrays(self, file, group)
    class(forest_t), intent(in) :: self
    type(h5_writer_t), intent(inout) :: file
    !> without its last slash; empty = the root
    character(*), intent(in) :: group

    call file%write(group // '/parameter_names', self%parameter_names)
    call file%write(group // '/lowest', self%lowest, description='features are parameters from 0 to 1 between both')
    call file%write(group // '/highest', self%highest)
    call file%write(group // '/tree_starts', self%tree_starts, description='first node of each tree, 0-based, and the end')
    call file%write(group // '/feature', self%feature, description='parameter that a node looks at, 0-based, -1 in a leaf')
    call file%write(group // '/threshold', self%threshold, description='threshold of each node: values up to it go to the ' // &
      'left child')
    call file%write(group // '/left', self%left, description='left child of each node, counted from the first node of the tree')
    call file%write(group // '/right', self%right)
    call file%write(group // '/shares', self%shares, description='share of each cluster in a leaf, a node per row')
  end subroutine write_arrays
end module sig_forest
