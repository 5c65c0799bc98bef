! SPDX-License-Identifier: BSD-3-Clause
!> Sobol's sequence: points that fill a box evenly for any number of points.
module sig_sobol
  use sig_deck_config, only: max_sobol_parameters
  use sig_kinds, only: lk, rk
  use sig_random_numbers, only: random_t
  implicit none(type, external)
  private
  public :: sobol_points

  !> Degree s, coefficients a and first direction numbers m of a primitive polynomial.
  type :: polynomial_t
    integer :: degree
    integer :: coefficients
    integer :: first_numbers(5)
  end type polynomial_t

  integer, parameter :: n_bits = 32
  !> polynomials of the second parameter, the third, ...; Joe and Kuo, SIAM J. Sci. Comput. 30 (2008) 2635, table "new-joe-kuo-6"
  type(polynomial_t), parameter :: polynomials(2:max_sobol_parameters) = [ &
                                   polynomial_t(1, 0, [1, 0, 0, 0, 0]), polynomial_t(2, 1, [1, 3, 0, 0, 0]), &
                                   polynomial_t(3, 1, [1, 3, 1, 0, 0]), polynomial_t(3, 2, [1, 1, 1, 0, 0]), &
                                   polynomial_t(4, 1, [1, 1, 3, 3, 0]), polynomial_t(4, 4, [1, 3, 5, 13, 0]), &
                                   polynomial_t(5, 2, [1, 1, 5, 5, 17]), polynomial_t(5, 4, [1, 1, 5, 5, 5]), &
                                   polynomial_t(5, 7, [1, 1, 7, 11, 19])]

contains

  !> Returns the first n_points points of Sobol's sequence, in Gray-code order. With seed 0 the first point is the origin. With any
  !> other seed each parameter has a random pattern of bits, which changes the bits of its value at all points (digital shift): this
  !> gives other points, which are as even. The same seed gives the same points.
  function sobol_points(n_parameters, n_points, seed) result(points)
    !> 1 to max_sobol_parameters
    integer, intent(in) :: n_parameters
    integer, intent(in) :: n_points
    integer, intent(in) :: seed
    !> [-] in [0, 1), shape (n_parameters, n_points)
    real(rk) :: points(n_parameters, n_points)
    integer(lk) :: bits, directions(n_bits)
    integer :: i_parameter, i_point
    real(rk) :: fraction
    type(random_t) :: random

    random%state = seed
    do i_parameter = 1, n_parameters
      call random%fraction(fraction)
      bits = merge(int(fraction * 2.0_rk**n_bits, lk), 0_lk, seed /= 0)
      directions = direction_numbers(i_parameter)
      do i_point = 1, n_points
        points(i_parameter, i_point) = real(bits, rk) / 2.0_rk**n_bits
        ! Gray codes of neighbors differ in one bit: that of the number's lowest one.
        bits = ieor(bits, directions(1 + trailz(i_point)))
      end do
    end do
  end function sobol_points

  !> Returns the direction numbers v_k of one parameter, as whole numbers of n_bits bits.
  !>
  !> v_k = v_(k-s) xor v_(k-s) / 2**s xor those v_(k-i), 1 <= i < s, whose coefficient is 1; v_k = m_k / 2**k for k <= s. Of the
  !> first parameter v_k = 1 / 2**k.
  pure function direction_numbers(i_parameter) result(v)
    integer, intent(in) :: i_parameter
    integer(lk) :: v(n_bits)
    type(polynomial_t) :: polynomial
    integer :: i, k

    if (i_parameter == 1) then
      v = [(shiftl(1_lk, n_bits - k), k=1, n_bits)]
      return
    end if
    polynomial = polynomials(i_parameter)
    associate (s => polynomial%degree)
      v(:s) = [(shiftl(int(polynomial%first_numbers(k), lk), n_bits - k), k=1, s)]
      do k = s + 1, n_bits
        v(k) = ieor(v(k - s), shiftr(v(k - s), s))
        do i = 1, s - 1
          if (btest(polynomial%coefficients, s - 1 - i)) v(k) = ieor(v(k), v(k - i))
        end do
      end do
    end associate
  end function direction_numbers
end module sig_sobol
