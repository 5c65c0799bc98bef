! SPDX-License-Identifier: BSD-3-Clause
!> Makes trained reduced models the parts of a model.
module sig_model_parts
  use sig_compliance, only: compliance_t
  use sig_condensed_model, only: condensed_model_t
  use sig_hhr_data, only: hhr_data_t
  use sig_model, only: model_t
  use sig_reduced, only: part_t, reduced_t
  use sig_reduced_hhr, only: reduced_hhr_t
  implicit none(type, external)
  private
  public :: set_clusters, set_fallback, cluster_of, compliance_of

contains

  !> Replaces the clusters of the model by hyper-reduced clusters with copies of these data; an existing fallback stays.
  subroutine set_clusters(model, clusters)
    type(model_t), intent(inout) :: model
    !> in the order of the labels of the choice
    type(hhr_data_t), intent(in) :: clusters(:)
    type(part_t), allocatable :: parts(:)
    type(reduced_hhr_t), allocatable :: reduced
    integer :: k

    allocate (parts(size(clusters) + merge(1, 0, model%has_fallback)))
    do k = 1, size(clusters)
      allocate (reduced)
      reduced%data = clusters(k)
      call move_alloc(reduced, parts(k)%reduced)
    end do
    k = model%fallback()
    if (k > 0) call move_alloc(model%parts(k)%reduced, parts(size(parts))%reduced)
    call move_alloc(parts, model%parts)
  end subroutine set_clusters

  !> Sets the part that answers where the clusters cannot. The part is moved into the model. If it is not allocated, nothing
  !> changes.
  subroutine set_fallback(model, fallback)
    !> a model without a fallback
    type(model_t), intent(inout) :: model
    !> in: the part, or not allocated; out: not allocated
    class(reduced_t), allocatable, intent(inout) :: fallback
    type(part_t), allocatable :: parts(:)
    integer :: k, n

    if (.not. allocated(fallback)) return
    n = model%n_clusters()
    allocate (parts(n + 1))
    do k = 1, n
      call move_alloc(model%parts(k)%reduced, parts(k)%reduced)
    end do
    call move_alloc(fallback, parts(n + 1)%reduced)
    call move_alloc(parts, model%parts)
    model%has_fallback = .true.
  end subroutine set_fallback

  !> Returns a pointer to the data of part k (1-based) of the model if this part is hyper-reduced; otherwise null.
  function cluster_of(model, k) result(cluster)
    type(model_t), target, intent(in) :: model
    integer, intent(in) :: k
    type(hhr_data_t), pointer :: cluster

    cluster => null()
    select type (part => model%parts(k)%reduced)
    type is (reduced_hhr_t)
      cluster => part%data
    end select
  end function cluster_of

  !> Returns a pointer to the compliance of part k (1-based) of the model if this part is condensed; otherwise null.
  function compliance_of(model, k) result(compliance)
    type(model_t), target, intent(in) :: model
    integer, intent(in) :: k
    class(compliance_t), pointer :: compliance

    compliance => null()
    select type (part => model%parts(k)%reduced)
    type is (condensed_model_t)
      compliance => part%compliance
    end select
  end function compliance_of
end module sig_model_parts
