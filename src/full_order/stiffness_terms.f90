! SPDX-License-Identifier: BSD-3-Clause
!> The stiffness as a sum of terms, K = K_0 + sum over q of theta_q K_q. Each material whose elastic constants depend on the
!> parameters gives two terms, with its bulk and its shear modulus as theta_q > 0. All K_q are positive semidefinite. K_0 belongs to
!> the other materials.
module sig_stiffness_terms
  use sig_elastic_body, only: elastic_body_t
  use sig_elasticity, only: hooke_term, n_hooke_terms
  use sig_kinds, only: rk
  implicit none(type, external)
  private
  public :: stiffness_term_t, body_of_term, body_of_rest, list_stiffness_terms

  !> One term q.
  type :: stiffness_term_t
    !> number of the material in the deck, 1-based
    integer :: material = 1
    !> number of hooke_term: 1 = bulk, 2 = shear
    integer :: i_hooke = 1
  end type stiffness_term_t

contains

  !> Lists the terms: bulk and shear of the first material that varies, then of the next one, ...
  pure subroutine list_stiffness_terms(is_varying, parts)
    !> whether the elastic constants of each material depend on the parameters, shape (n_materials)
    logical, intent(in) :: is_varying(:)
    !> the terms, two (n_hooke_terms) of each material that varies
    type(stiffness_term_t), allocatable, intent(out) :: parts(:)
    integer :: i, i_hooke, n

    allocate (parts(n_hooke_terms * count(is_varying)))
    n = 0
    do i = 1, size(is_varying)
      if (.not. is_varying(i)) cycle
      do i_hooke = 1, n_hooke_terms
        n = n + 1
        parts(n)%material = i
        parts(n)%i_hooke = i_hooke
      end do
    end do
  end subroutine list_stiffness_terms

  !> Makes bodies whose stiffness is K_q: the material of the term has hooke_term, all other materials have no stiffness.
  subroutine body_of_term(part, body, own)
    !> the term q
    type(stiffness_term_t), intent(in) :: part
    !> its materials are those of the deck
    type(elastic_body_t), intent(in) :: body
    !> a copy of body with other matrices of elasticity
    type(elastic_body_t), intent(out) :: own
    real(rk) :: matrices(size(body%stress_matrix, 1), size(body%stress_matrix, 2), size(body%stress_matrix, 3))

    own = body
    matrices = 0
    matrices(:, :, part%material) = hooke_term(body%model, part%i_hooke)
    call own%set_stresses(matrices)
  end subroutine body_of_term

  !> Makes bodies whose stiffness is K_0: the materials of the terms have no stiffness, all other materials are unchanged.
  subroutine body_of_rest(parts, body, own)
    !> of list_stiffness_terms
    type(stiffness_term_t), intent(in) :: parts(:)
    type(elastic_body_t), intent(in) :: body
    !> a copy of body with other matrices of elasticity
    type(elastic_body_t), intent(out) :: own
    real(rk) :: matrices(size(body%stress_matrix, 1), size(body%stress_matrix, 2), size(body%stress_matrix, 3))
    integer :: i

    own = body
    matrices = body%stress_matrix
    do i = 1, size(parts)
      matrices(:, :, parts(i)%material) = 0
    end do
    call own%set_stresses(matrices)
  end subroutine body_of_rest
end module sig_stiffness_terms
