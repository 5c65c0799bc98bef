! SPDX-License-Identifier: BSD-3-Clause
!> Integration points of one facet of the first surface of a contact, each with the place of the second surface that it faces.
module sig_facing_points
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: facing_points_t

  !> A list of points: call clear, then add each point.
  type :: facing_points_t
    !> number of points
    integer :: n = 0
    !> facet of the second surface, shape (n) used, like all others
    integer, allocatable :: i_other(:)
    !> whether this facet lies farther away than the search distance
    logical, allocatable :: is_far(:)
    !> [length**(n_dim - 1)] weights of integrals over the first surface, in axisymmetry over its meridian
    real(rk), allocatable :: weights(:)
    !> [-] in the reference elements of both facets, shape (n_dim - 1, n)
    real(rk), allocatable :: places(:, :)
    real(rk), allocatable :: opposite(:, :)
    !> [length] distance to the second surface along the normal, negative where they overlap
    real(rk), allocatable :: gaps(:)
  contains
    procedure :: clear
    procedure :: add
  end type facing_points_t

contains

  !> Empties the list and keeps its memory; the first call allocates it.
  pure subroutine clear(self, n_dim)
    class(facing_points_t), intent(inout) :: self
    !> dimension of a facet: 1 or 2, the same in each call
    integer, intent(in) :: n_dim
    integer, parameter :: usual = 256

    self%n = 0
    if (allocated(self%gaps)) return
    allocate (self%i_other(usual), self%is_far(usual), self%weights(usual), self%gaps(usual))
    allocate (self%places(n_dim, usual), self%opposite(n_dim, usual))
  end subroutine clear

  !> Adds a point. Each argument is what the component of facing_points_t with the argument's name, or its plural, holds for this
  !> point. Requires: clear.
  pure subroutine add(self, i_other, is_far, weight, place, opposite, gap)
    class(facing_points_t), intent(inout) :: self
    integer, intent(in) :: i_other
    logical, intent(in) :: is_far
    real(rk), intent(in) :: weight, place(:), opposite(:), gap

    if (self%n == size(self%gaps)) then
      self%i_other = [self%i_other, self%i_other]
      self%is_far = [self%is_far, self%is_far]
      self%weights = [self%weights, self%weights]
      self%gaps = [self%gaps, self%gaps]
      self%places = reshape([self%places, self%places], [size(place), 2 * self%n])
      self%opposite = reshape([self%opposite, self%opposite], [size(place), 2 * self%n])
    end if
    self%n = self%n + 1
    self%i_other(self%n) = i_other
    self%is_far(self%n) = is_far
    self%weights(self%n) = weight
    self%places(:, self%n) = place
    self%opposite(:, self%n) = opposite
    self%gaps(self%n) = gap
  end subroutine add
end module sig_facing_points
