! SPDX-License-Identifier: BSD-3-Clause
!> Windows on surfaces, integration points of a facet, and Gauss points on (0, 1).
module sig_facet_points
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: window_t, facet_rule_t, make_room, add_point
  public :: n_gauss, gauss_points, gauss_weights, n_fine, fine_points, fine_weights

  !> The part of a surface between two values of one coordinate.
  type :: window_t
    !> number of the bounded coordinate, 0 = no window
    integer :: axis = 0
    !> [length] bounds of this coordinate; huge = no bound
    real(rk) :: minimum = -huge(1.0_rk)
    real(rk) :: maximum = huge(1.0_rk)
    !> the bounds cut facets; otherwise a facet counts as a whole where all its nodes are inside, and else not at all
    logical :: is_cut = .true.
  end type window_t

  !> Integration points of one facet; none where the facet lies outside of the window. Arrays may have room for more points.
  type :: facet_rule_t
    integer :: n_points = 0
    !> [length] coordinates of the points, shape (n_dim, n_points)
    real(rk), allocatable :: places(:, :)
    !> [-] shape functions at the points, shape (n_nodes, n_points)
    real(rk), allocatable :: values(:, :)
    !> [length**(n_dim - 1)] weight times unit normal, shape (n_dim, n_points); the order of the nodes gives the side of the normal
    real(rk), allocatable :: area_vectors(:, :)
  end type facet_rule_t

  !> Gauss points on (0, 1) and their weights: exact for polynomials of degree 7
  integer, parameter :: n_gauss = 4
  real(rk), parameter :: inner = sqrt(3.0_rk / 7 - sqrt(6.0_rk / 5) * 2 / 7), outer = sqrt(3.0_rk / 7 + sqrt(6.0_rk / 5) * 2 / 7)
  real(rk), parameter :: gauss_points(n_gauss) = [1 - outer, 1 - inner, 1 + inner, 1 + outer] / 2
  real(rk), parameter :: gauss_weights(n_gauss) = [18 - sqrt(30.0_rk), 18 + sqrt(30.0_rk), 18 + sqrt(30.0_rk), &
    18 - sqrt(30.0_rk)] / 72
  !> 12 Gauss points on (0, 1), for functions that are no polynomials, as where a bound of a window cuts a curved face or a
  !> quadrilateral with unequal sides
  integer, parameter :: n_fine = 12
  real(rk), parameter :: half_points(6) = [0.12523340851146891547_rk, 0.36783149899818019375_rk, 0.58731795428661744730_rk, &
    0.76990267419430468704_rk, 0.90411725637047485668_rk, 0.98156063424671925069_rk]
  real(rk), parameter :: half_weights(6) = [0.24914704581340278500_rk, 0.23349253653835480876_rk, 0.20316742672306592175_rk, &
    0.16007832854334622633_rk, 0.10693932599531843096_rk, 0.04717533638651182719_rk]
  real(rk), parameter :: fine_points(n_fine) = [1 - half_points, 1 + half_points] / 2
  real(rk), parameter :: fine_weights(n_fine) = [half_weights, half_weights] / 2

contains

  !> Makes the arrays of `rule` large enough for n_points points. Arrays that are large enough and fit the facet stay as they are;
  !> others are allocated again, and their points are lost. rule%n_points does not change.
  pure subroutine make_room(vertices, n_points, rule)
    !> [length] coordinates of the nodes, shape (n_dim, n_nodes)
    real(rk), intent(in) :: vertices(:, :)
    !> number of all points that the arrays must hold
    integer, intent(in) :: n_points
    type(facet_rule_t), intent(inout) :: rule

    if (allocated(rule%places)) then
      if (size(rule%places, 2) >= n_points .and. size(rule%places, 1) == size(vertices, 1) .and. &
        size(rule%values, 1) == size(vertices, 2)) return
      deallocate (rule%places, rule%values, rule%area_vectors)
    end if
    allocate (rule%places(size(vertices, 1), n_points), rule%values(size(vertices, 2), n_points))
    allocate (rule%area_vectors(size(vertices, 1), n_points))
  end subroutine make_room

  !> Appends a point to `rule`, whose arrays must be large enough for it (make_room). Its place is the sum of shape functions times
  !> nodes.
  pure subroutine add_point(vertices, values, area_vector, rule)
    !> [length] coordinates of the nodes, shape (n_dim, n_nodes)
    real(rk), intent(in) :: vertices(:, :)
    !> [-] shape functions at the point; only the first n_nodes are used
    real(rk), intent(in) :: values(:)
    !> [length**(n_dim - 1)] weight times unit normal; only the first n_dim are used
    real(rk), intent(in) :: area_vector(3)
    type(facet_rule_t), intent(inout) :: rule
    integer :: k

    rule%n_points = rule%n_points + 1
    associate (i => rule%n_points)
      rule%values(:, i) = values(:size(vertices, 2))
      rule%area_vectors(:, i) = area_vector(:size(vertices, 1))
      rule%places(:, i) = 0
      do k = 1, size(vertices, 2)
        rule%places(:, i) = rule%places(:, i) + values(k) * vertices(:, k)
      end do
    end associate
  end subroutine add_point
end module sig_facet_points
