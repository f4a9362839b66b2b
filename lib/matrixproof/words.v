(* What the certificates need: numbers for `field`, and rules that multiply out. *)
From Coq Require Export Field.
From mathcomp Require Export all_ssreflect all_algebra.
Export GRing.Theory Num.Theory.
#[global] Open Scope ring_scope.

Section Numbers.
Variable F : numFieldType.
Implicit Types x y : F.
Definition zero : F := 0.
Definition one : F := 1.
Definition add x y : F := x + y.
Definition opp x : F := - x.
Definition sub x y : F := x - y.
Definition mul x y : F := x * y.
Definition inv x : F := x^-1.
Definition div x y : F := x / y.

Lemma numbers : field_theory zero one add mul sub opp div inv eq.
Proof.
split=> [||//|x /eqP nonzero]; last by rewrite /mul mulVf.
- split=> // *; rewrite /add /mul /zero /one /opp;
  by [rewrite add0r|rewrite addrC|rewrite addrA|rewrite mul1r
     |rewrite mulrC|rewrite mulrA|rewrite mulrDl|rewrite subrr].
- exact/eqP/oner_neq0.
Qed.

Lemma nD x y : x + y = add x y. Proof. by []. Qed.
Lemma nN x : - x = opp x. Proof. by []. Qed.
Lemma nM x y : x * y = mul x y. Proof. by []. Qed.
Lemma nV x : x^-1 = inv x. Proof. by []. Qed.
Lemma n0 : 0 = zero. Proof. by []. Qed.
Lemma n1 : 1 = one. Proof. by []. Qed.
Lemma nS n : n.+1%:R = add one n%:R. Proof. exact: mulrS. Qed.
Lemma nA m n : (m + n)%:R = add m%:R n%:R. Proof. exact: natrD. Qed.
Lemma nO : 0%:R = zero. Proof. by []. Qed.
Definition natural n : F := n%:R.
Lemma nZ n : n%:R = natural n. Proof. by []. Qed.
Lemma nX x n : x ^+ n.+1 = mul x (x ^+ n). Proof. exact: exprS. Qed.
Lemma nXO x : x ^+ 0 = one. Proof. by []. Qed.

Lemma by_numbers x y : x = y :> F -> x = y. Proof. by []. Qed.
Lemma use c l r : l = r -> forall a b, a = add b (mul c (add l (opp r))) -> a = b.
Proof. by rewrite /add /mul /opp => -> a b ->; rewrite subrr mulr0 addr0. Qed.
End Numbers.

Section Matrices.
Variables (F : numFieldType) (k m n p q : nat).
Implicit Types (A B : 'M[F]_(m, n)) (c : F).
Lemma around (u : 'M[F]_(k, m)) (v : 'M[F]_(n, q)) A B :
  A = B -> u *m A *m v = u *m B *m v.
Proof. by move->. Qed.
Lemma trace_around (u : 'M[F]_(k, m)) (v : 'M[F]_(n, k)) A B :
  A = B -> \tr (u *m A *m v) = \tr (u *m B *m v).
Proof. by move->. Qed.
Lemma turned A B : A = B -> A^T = B^T.
Proof. by move->. Qed.
Lemma scaled c A (B : 'M[F]_(n, p)) : c *: A *m B = c *: (A *m B).
Proof. by rewrite scalemxAl. Qed.
Lemma scaled_behind c A (B : 'M[F]_(n, p)) : A *m (c *: B) = c *: (A *m B).
Proof. by rewrite scalemxAr. Qed.
Lemma turnedM A (B : 'M[F]_(n, p)) : (A *m B)^T = B^T *m A^T.
Proof. exact: trmx_mul. Qed.
Lemma cyclic A (B : 'M[F]_(n, m)) : \tr (A *m B) = \tr (B *m A).
Proof. exact: mxtrace_mulC. Qed.
Lemma turnedD A B : (A + B)^T = A^T + B^T. Proof. exact: raddfD. Qed.
Lemma turnedN A : (- A)^T = - A^T. Proof. exact: raddfN. Qed.
Lemma turnedZ c A : (c *: A)^T = c *: A^T. Proof. exact: linearZ. Qed.
Definition entry A i j : F := A i j.
Lemma by_entries A B : (forall i j, entry A i j = entry B i j) -> A = B.
Proof. by move=> E; apply/matrixP. Qed.
Lemma at_entry i j A B : A = B -> entry A i j = entry B i j. Proof. by move->. Qed.
Lemma eD A B i j : entry (A + B) i j = add F (entry A i j) (entry B i j).
Proof. exact: mxE. Qed.
Lemma eN A i j : entry (- A) i j = opp F (entry A i j). Proof. exact: mxE. Qed.
Lemma eZ c A i j : entry (c *: A) i j = mul F c (entry A i j).
Proof. exact: mxE. Qed.
Lemma e0 i j : entry 0 i j = zero F. Proof. exact: mxE. Qed.
End Matrices.

Section Square.
Variables (F : numFieldType) (n : nat).
Implicit Types (A : 'M[F]_n).
Definition trace A : F := \tr A.
Lemma nT A : \tr A = trace A. Proof. by []. Qed.
Lemma traceN A : \tr (- A) = - \tr A. Proof. exact: raddfN. Qed.
Lemma trace_turned A : \tr A = \tr A^T. Proof. by rewrite mxtrace_tr. Qed.
Lemma number_turned (A : 'M[F]_1) : A = A^T.
Proof. by apply/matrixP=> i j; rewrite !mxE !ord1. Qed.
Lemma numbers_commute (A B : 'M[F]_1) : A *m B = B *m A.
Proof. by rewrite [A]mx11_scalar [B]mx11_scalar scalar_mxC. Qed.
Lemma exchanged A B c : c != 0 -> A *m B = c *: 1%:M -> B *m A = c *: 1%:M.
Proof.
move=> nonzero E; have: A *m (c^-1 *: B) = 1%:M.
  by rewrite scaled_behind E scalerA mulVf // scale1r.
move/mulmx1C; rewrite scaled => /(congr1 (fun Z => c *: Z)).
by rewrite scalerA mulfV // scale1r.
Qed.
End Square.

Arguments use {F} c {l r}.
Arguments around {F k m n q} u v {A B}.
Arguments trace_around {F k m n} u v {A B}.
Arguments turned {F m n A B}.
Arguments cyclic {F m n} A B.
Arguments at_entry {F m n} i j {A B}.
Arguments trace_turned {F n} A.
Arguments number_turned {F} A.
Arguments numbers_commute {F} A B.

(* Multi-rules: what multiplies out, what takes an entry, what is seen by `field`. *)
Ltac multiply := rewrite ?(mulmxDl, mulmxDr, mulmxN, mulNmx, mulmx0, mul0mx, mulmx1,
  mul1mx, scaled, scaled_behind, mulmxA, turnedD, turnedN, turnedZ, turnedM, trmxK,
  trmx1, trmx0).
Ltac multiply_in H := rewrite ?(mulmxDl, mulmxDr, mulmxN, mulNmx, mulmx0, mul0mx,
  mulmx1, mul1mx, scaled, scaled_behind, mulmxA, turnedD, turnedN, turnedZ, turnedM,
  trmxK, trmx1, trmx0) in H.
Ltac plain := rewrite ?(nT, nD, nN, nM, nV, nX, nXO, nA, nS, nO, n0, n1, nZ).
Ltac plain_in H := rewrite ?(nT, nD, nN, nM, nV, nX, nXO, nA, nS, nO, n0, n1, nZ) in H.

(* The claim, at an entry; then a term of the certificate, at the same entry. *)
Ltac entry_of i j :=
  multiply; apply: by_entries; intros i j; rewrite ?(eD, eN, eZ, e0); plain.
Ltac term_of i j c E :=
  let H := fresh in pose proof E as H; multiply_in H;
  let K := fresh in pose proof (at_entry i j H) as K; rewrite ?(eD, eN, eZ, e0) in K;
  let L := fresh in pose proof (use c K) as L; plain_in L; refine (L _ _ _); clear H K L.
(* The same for traces. *)
Ltac trace_of :=
  multiply; rewrite ?(mxtraceD, traceN, mxtraceZ, mxtrace1, mxtrace0);
  apply: by_numbers; plain.
Ltac trace_term_of c E :=
  let H := fresh in pose proof E as H; multiply_in H;
  rewrite ?(mxtraceD, traceN, mxtraceZ, mxtrace1, mxtrace0) in H;
  let L := fresh in pose proof (use c H) as L; plain_in L; refine (L _ _ _); clear H L.
Ltac nonzero := let E := fresh in intro E; match goal with H : is_true (~~ _) |- _ =>
  apply: (elimN eqP H); apply: by_numbers;
  first [exact: E | plain; apply: (eq_trans _ E); ring] end.
